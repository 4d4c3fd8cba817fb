#pragma once

#include <vector>

#include "tagcal/detect/tag_fit/picture_processing.hpp"
#include "tagcal/detect/tag_fit/printed_lines.hpp"

// Private to detect.
namespace tagcal::internal {

// Terms that the fits of all tags of a picture share: the camera's processing and the print.
struct PictureTerms {
  CameraProcessing processing;
  PrintedLines print;

  bool is_none() const { return processing.is_none() && print.is_none(); }
};

// Estimates both from the tags, given with their exact patterns.
PictureTerms terms_of_picture(const ImageView8& image, std::vector<TagInPicture> tags);

}  // namespace tagcal::internal
