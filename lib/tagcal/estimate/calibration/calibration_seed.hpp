#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// One view of a data set, ready for the solvers.
struct CalibrationView {
  std::string image;                 // for people; `index` is which it is
  std::size_t index = 0;             // in the data set
  std::vector<CornerId> ids;         // per correspondence
  std::vector<std::size_t> corners;  // likewise: observations of the view, by number
  ViewProblem problem;               // points in world coordinates
  std::vector<std::size_t> seed;     // the correspondences of the board that has most of them here

  // "desk.png", or "view 3" where it has no name.
  std::string name() const { return image.empty() ? "view " + std::to_string(index) : image; }
};

// Where the solver starts: free parameters, and per view a pose (none where no consensus was found)
// and the correspondences that agree with it.
struct CalibrationStart {
  std::vector<double> free_values;
  std::vector<std::optional<Pose>> camera_from_world;
  std::vector<std::vector<std::uint8_t>> inlier;
};

// What is known before, and by how many threads the rest is found.
struct StartOptions {
  const Lens* lens = nullptr;  // the start for models of its kind; it must outlive the call
  double focal_px = 0;         // where no lens is the start: a focal length; 0: not known
  bool keep_all = false;       // a view without a consensus starts by all of its corners
  std::size_t num_threads = 1;
};

// Closed form on consensus: which corners of each view agree on one projective map, then the focal
// length, unless it is known, of Zhang's closed form and a ladder of others, whose closed-form
// poses fit best. No value where no view has a consensus.
std::optional<CalibrationStart> find_start(const Model& model, const ImageSize& size,
                                           const std::vector<CalibrationView>& views,
                                           const StartOptions& options = {});

// The pose of one view for a known lens, from the corners that agree on one; no value where none
// do.
std::optional<Pose> consensus_pose(const CalibrationView& view, const Lens& lens);

}  // namespace tagcal::internal
