#pragma once

#include <vector>

#include "tagcal/detect/refine.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

struct TagInPicture {
  const TagPattern* pattern = nullptr;
  Quad corners;
  const Camera* camera = nullptr;  // as in TagFitOptions
  bool is_rough = false;
};

// Estimates gamma, grey level = light^gamma (TagFitOptions::gamma), from two of the picture's tags:
// the value with the highest likelihood of their blurred borders. 1 unless that is clearly worse.
double gamma_of_picture(const ImageView8& image, std::vector<TagInPicture> tags);

}  // namespace tagcal::internal
