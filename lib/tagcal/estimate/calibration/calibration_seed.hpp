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
  std::string image;          // a name for people; `index` identifies the view
  std::size_t index = 0;      // in the data set
  std::vector<CornerId> ids;  // per correspondence
  // Per correspondence: index of the observation in the view.
  std::vector<std::uint32_t> corners;
  ViewProblem problem;              // points in world coordinates
  std::vector<std::uint32_t> seed;  // correspondences of the view's largest board

  // "desk.png", or "view 3" without a name.
  std::string name() const { return image.empty() ? "view " + std::to_string(index) : image; }
};

// The start of the solver: free parameters, and per view a pose (none without a consensus) and its
// inliers.
struct CalibrationSeed {
  std::vector<double> free_values;
  std::vector<std::optional<Pose>> camera_from_world;
  std::vector<std::vector<std::uint8_t>> inlier;
};

struct SeedOptions {
  const Lens* lens = nullptr;  // start for models of its lens type; must outlive the call
  double focal_px = 0;         // start for all other models; 0: unknown
  bool keep_all = false;       // a view without a consensus starts from all of its corners
  std::size_t num_threads = 1;
};

// Closed-form start: the inliers of one projective map per view (projective_lmeds); then the focal
// length, unless it is known, whose closed-form poses fit best, of Zhang's closed form and a
// geometric grid. No value if no view has a consensus.
std::optional<CalibrationSeed> calibration_seed(const Model& model, const ImageSize& size,
                                                const std::vector<CalibrationView>& views,
                                                const SeedOptions& options = {});

}  // namespace tagcal::internal
