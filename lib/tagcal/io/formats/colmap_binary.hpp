#pragma once

#include <string>

// COLMAP's binary files as the text of cameras.txt and images.txt. `file` is the name in messages.

namespace tagcal::internal {

// Throws Error for a truncated file and for a number of a camera model that COLMAP does not have.
std::string colmap_cameras_text(const std::string& bytes, const std::string& file);
std::string colmap_images_text(const std::string& bytes, const std::string& file);

}  // namespace tagcal::internal
