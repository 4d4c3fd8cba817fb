#pragma once

#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/opencv/picture_shift.hpp"

// Private to detect: tags that are followed from one picture of a sequence to the next.
namespace tagcal::internal {

class TagFollower {
 public:
  // Picture, detector and family must outlive it.
  TagFollower(const ImageView8& image, const FamilyDetector& detector, const TagFamily& family,
              const CellSurroundings& surroundings);

  // Adds the tags of one panel in this picture, from those in the picture before. The one in the
  // middle is found by the shift between the pictures, the others outwards, each by the homography
  // from picture to picture of the nearest ones. Tags that leave the picture are left out. False if
  // another tag is lost.
  bool follow(std::vector<const FoundTag*> before, const PictureShift& shift,
              std::vector<FoundTag>& tags);

 private:
  std::optional<FoundTag> find_first(const FoundTag& before, const Quad& start) const;
  std::optional<FoundTag> find_next(const FoundTag& before, const Quad& start) const;
  std::optional<Quad> predicted_place(const PlacedTag& tag) const;

  ImageView8 image_;
  const FamilyDetector& detector_;
  const TagFamily& family_;
  CellSurroundings surroundings_;
  std::vector<PlacedTag> found_;  // places in the picture before, and in this one
};

}  // namespace tagcal::internal
