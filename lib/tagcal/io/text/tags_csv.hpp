#pragma once

#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"

namespace tagcal::internal {

// The corners of tags without a board as a file of observations with one more column: `instance`
// counts the tags of one id in an image, from 0. `tags` has a list for each image. Throws Error for
// a name of an image that is not one line.
std::string tags_csv(const std::vector<std::string>& images,
                     const std::vector<std::vector<DetectedTag>>& tags);

}  // namespace tagcal::internal
