#pragma once

#include "tagcal/detect/board_search/complete_board.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect: tags that surely are the target's. Kalibr's tags have a border of 2 bits,
// plain ones of 1; each kind is sometimes read as the other: too few tags, with displaced corners.
namespace tagcal::internal {

// True if border, frame and bits of a found tag agree with its pattern. (Bits alone often agree
// with the other border, and small families are read in any shape with four sides.)
bool is_sure(const ImageView8& image, const FoundTag& tag, const TagFamily& family);

// Numbers of the boards' tags in a picture.
struct TagCount {
  int sure = 0;
  int unread = 0;  // expected in the picture, but not found, or not surely

  void add(const ImageView8& image, const Completion& completion, const TagFamily& family);
};

}  // namespace tagcal::internal
