#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

namespace tagcal {

// Finds the corners of the boards' tags and checkerboards and the centres of their circles
// in one picture. Tags that are on no
// board, and tags of one id seen at two places, are not reported but named in the warnings, which
// begin with `name`, as does an Error. Pictures with a side below 8 px are not searched. Corners:
// pixel centres at whole numbers. Throws Error if the picture's size differs from that of the given
// camera.
DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options = {}, const std::string& name = "picture");

// The same for many pictures, in parallel. The answer does not depend on the number of threads. If
// the pictures show tags with another border than the boards', a warning of the result names it.
// `progress(done, total)` is called under a lock after each image.
DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options = {},
                        const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
