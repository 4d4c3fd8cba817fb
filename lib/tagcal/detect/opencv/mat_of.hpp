#pragma once

#include <opencv2/core.hpp>

#include "tagcal/scene/image.hpp"

// Private to this room.
namespace tagcal::internal {

// OpenCV's name for the pixels of a picture, which it takes as not constant, but reads only.
inline cv::Mat mat_of(const ImageView8& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride())};
}

}  // namespace tagcal::internal
