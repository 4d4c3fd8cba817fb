#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/policy/policy.hpp"

// Private to detect: pictures of tags with another border than the target file says. Kalibr's tags
// have a border of 2 bits, plain ones of 1. Each kind is sometimes read as the other: too few tags,
// with displaced corners.
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

// True if a picture shows another kind of tags than the target's: `read` of that kind were surely
// read, and `of_target` of the target's.
inline bool shows_other_kind(int read, int of_target) {
  return read >= policy::kOtherTagsRatio * std::max(1, of_target);
}

// A warning if the pictures show the boards with the other border. Searches only pictures with more
// unread than sure tags for the other border, and only a few of them until one shows it: ordinary
// sets have few such pictures, and each costs another search.
std::vector<std::string> wrong_border_warnings(const std::vector<ImageSource>& images,
                                               const std::vector<DetectedPicture>& found,
                                               const std::vector<PlacedBoard>& boards,
                                               const DetectOptions& options);

}  // namespace tagcal::internal
