#pragma once

#include <functional>
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

// The fit of a pattern at its place in a picture with some processing, by every `row_step`-th row.
using PatternPart = std::function<PatternFit(const CameraProcessing&, int row_step)>;

// Estimates a picture's processing from the first of some patterns: that of the highest likelihood
// of their blurred borders and of their noise. Gamma is 1, and the amount 0, unless that is clearly
// worse.
CameraProcessing processing_of_parts(const std::vector<PatternPart>& parts);

// The same from tags.
CameraProcessing processing_of_picture(const ImageView8& image,
                                       const std::vector<TagInPicture>& tags);

// The order in which patterns serve: the smallest of those that are large enough, which cost least,
// then the largest of the others.
double order_of_part(double side_px);

}  // namespace tagcal::internal
