#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

namespace tagcal {

// Finds the corners of the boards' tags in one picture. Tags of the family that are on none of the
// boards are left out, and said in `warnings`, as is a tag seen twice (both are left out). Pictures
// smaller than 8x8 hold no tag. Corners: pixel centres at whole numbers.
// Throws Error where the picture has not the size of the camera that is given.
View detect(const Image8& image, const std::string& name, const std::vector<PlacedBoard>& boards,
            const DetectOptions& options, std::vector<std::string>* warnings);

// The same for many pictures, several at once. The answer does not depend on the number of threads.
// Where the pictures show tags with another border than the boards say, the first warning says so.
// `progress(done, total)` is called from the calling thread's side, under a lock, after each image.
DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options,
                        const std::function<void(int, int)>& progress = {});

}  // namespace tagcal
