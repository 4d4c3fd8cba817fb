#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag_handles.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/refine_edges.hpp"
#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal {

// The tags looked for with one family and border.
struct Wanted {
  std::string family;
  int border_bits = 1;
  std::set<int> ids;
  bool corner_squares = false;
  std::map<int, TagSurroundings> surroundings;  // by id, where known
};

struct FoundTag {
  int id = 0;
  Quad corners;
  bool refined = false;
  std::optional<Eigen::Matrix<double, 8, 8>> covariance_px2 =
      std::nullopt;  // of (x0, y0, x1, y1, ..)
};

// AprilTag's detector for one family and border, for one thread.
class FamilyDetector {
 public:
  FamilyDetector(const Wanted& wanted, const DetectOptions& options);

  const Wanted& wanted() const { return wanted_; }

  // All tags of the family whole in the picture, wanted or not, which must be 8x8 at least.
  std::vector<FoundTag> find(const Image8& image);

  // Four-sided black shapes in the last picture, tags or not.
  int num_quads() const { return num_quads_; }

  // A tag known to be there, its corners to 2 px; no value where the picture does not let them be
  // found. Stock corners are made finer by their edges here.
  std::optional<FoundTag> refined(const Image8& image, int id, const Quad& start);

 private:
  void look(const Image8& image, const Image8& shrunk, int shrink, std::vector<FoundTag>& found);
  std::optional<FoundTag> named(const apriltag_detection_t& detection, const Image8& image,
                                int shrink);
  bool fit(FoundTag& tag, const Image8& image);

  Wanted wanted_;
  FamilyHandle family_;
  DetectorHandle detector_;
  int max_hamming_;
  Refinement refinement_;
  TagFamily patterns_of_;
  std::map<int, TagPattern> patterns_;  // of tags seen before
  int num_quads_ = 0;
};

}  // namespace tagcal
