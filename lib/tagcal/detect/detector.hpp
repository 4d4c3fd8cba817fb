#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

namespace tagcal {

// Finds the corners of the boards' tags and checkerboards and the centres of their circles in one
// picture. Tags that are on no board, and tags of one id seen at two places, are not reported but
// named in the warnings, which begin with `name`, as does an Error. Pictures with a side below 8 px
// are not searched. Corners: pixel centres at whole numbers. Throws Error if the picture's size
// differs from that of the given camera.
DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options = {}, const std::string& name = "picture");

// The same for many pictures, in parallel, in their order. The answer does not depend on the number
// of threads. `progress(done, total)` is called under a lock after each image. Throws what loading
// a picture throws, unless DetectOptions::skip_unreadable.
std::vector<DetectedPicture> detect_all(const std::vector<ImageSource>& images,
                                        const std::vector<PlacedBoard>& boards,
                                        const DetectOptions& options = {},
                                        const std::function<void(int, int)>& progress = {});

// The views of a data set.
std::vector<View> views_of(const std::vector<DetectedPicture>& pictures);

// Finds every tag of a family in one picture, without a board: each lies whole in the picture, and
// each place is reported once, ordered by id and, where an id is repeated, from left to right.
// Corners are refined as by detect(). A lens that bends the sides of a large tag is known only from
// DetectOptions::camera. Pictures with a side below 8 px show none.
// Throws Error as tag_family() does, and if the picture's size differs from the camera's.
std::vector<DetectedTag> detect_tags(const ImageView8& image, const TagKind& kind,
                                     const DetectOptions& options = {});

// The same for many pictures, as detect_all().
std::vector<PictureTags> detect_all_tags(const std::vector<ImageSource>& images,
                                         const TagKind& kind, const DetectOptions& options = {},
                                         const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
