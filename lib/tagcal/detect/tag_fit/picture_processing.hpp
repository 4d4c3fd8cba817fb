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

// A camera's processing of the light of a picture: TagFitOptions::gamma and sharpen.
struct CameraProcessing {
  double gamma = 1;
  Sharpen sharpen = {0, 1};

  bool is_none() const { return gamma == 1 && sharpen.amount == 0; }
};

// Estimates a picture's processing from the first two of its tags: that of the highest likelihood
// of their blurred borders and of their noise. Gamma is 1, and the amount 0, unless that is clearly
// worse.
CameraProcessing processing_of_picture(const ImageView8& image,
                                       const std::vector<TagInPicture>& tags);

}  // namespace tagcal::internal
