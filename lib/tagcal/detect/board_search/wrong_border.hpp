#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/board_finder.hpp"

// Private to detect: pictures of tags whose border is not the one that the target file says.
// Kalibr's tags have a border of 2 bits, plain ones of 1, and each kind can now and then be read as
// the other: too few tags, not quite on their place.
namespace tagcal::internal {

// Whether border, frame and bits of a tag that was found answer to its pattern. (Bits alone answer
// to those of the other border often enough, and small families are read out of anything that has
// four sides.)
bool is_sure(const Image8& image, const FoundTag& tag, const TagFamily& family);

// What a picture showed of the boards.
struct TagCount {
  std::size_t sure = 0;
  std::size_t unread = 0;  // should be in the picture, and are not found, or not surely

  void add(const Image8& image, const Completion& completion, const TagFamily& family);
};

// Whether a picture in which `read` tags of a kind are surely read, and `of_target` of the
// target's, rather shows that kind. Noise is read as one tag.
inline bool shows_other_kind(std::size_t read, std::size_t of_target) {
  return read >= 2 && read >= 2 * of_target;
}

// A warning where the pictures show the boards with the other border. Asks the pictures themselves,
// but only where more tags are unread than sure, and no more than a few of these while they do not
// say so: of ordinary pictures there are few, and each costs another search.
std::vector<std::string> wrong_border_warnings(const std::vector<ImageSource>& images,
                                               const std::vector<TagCount>& counts,
                                               const std::vector<PlacedBoard>& boards,
                                               const DetectOptions& options);

}  // namespace tagcal::internal
