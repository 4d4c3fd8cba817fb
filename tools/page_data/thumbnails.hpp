#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A small copy of a picture, for the page.
struct Thumbnail {
  std::string data_uri;  // of a JPEG; "": none
  ImageSize size;
  ImageSize picture_size;
  std::string problem;  // a sentence: why there is none
};

// "data:image/jpeg;base64,..", as a page shows it.
std::string jpeg_uri(const Picture& picture);

// Small copies of pictures, by the library's own resampling. An empty path is a picture that is not
// known. Pictures that cannot be read are no error. `image_size`: what all should have.
std::vector<Thumbnail> thumbnails(const std::vector<std::filesystem::path>& files,
                                  const ImageSize& image_size, int threads);

}  // namespace tagcal::tools
