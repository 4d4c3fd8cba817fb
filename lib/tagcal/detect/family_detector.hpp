#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag_handles.hpp"
#include "tagcal/detect/refine_edges.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal {

// The tags looked for with one family and border.
struct Wanted {
  std::string family;
  int border_bits = 1;
  std::set<int> ids;
  bool corner_squares = false;
};

struct FoundTag {
  int id = 0;
  Quad corners;
  bool refined = false;
};

// AprilTag's detector for one family and border, for one thread.
class FamilyDetector {
 public:
  FamilyDetector(const Wanted& wanted, int max_hamming);

  const Wanted& wanted() const { return wanted_; }

  // All tags of the family whole in the picture, wanted or not, which must be 8x8 at least.
  std::vector<FoundTag> find(const Image8& image);

  // Four-sided black shapes in the last picture, tags or not.
  int num_quads() const { return num_quads_; }

  // A tag known to be there, its corners to 2 px. No value where its edges cannot be fitted.
  std::optional<FoundTag> refined(const Image8& image, int id, const Quad& start) const;

 private:
  void look(const Image8& image, const Image8& shrunk, int shrink, std::vector<FoundTag>& found);
  std::optional<FoundTag> named(const apriltag_detection_t& detection, const Image8& image,
                                int shrink) const;

  Wanted wanted_;
  FamilyHandle family_;
  DetectorHandle detector_;
  int max_hamming_;
  int num_quads_ = 0;
};

}  // namespace tagcal
