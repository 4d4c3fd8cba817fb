#pragma once

#include <vector>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

struct TagInPicture {
  const TagPattern* pattern = nullptr;
  Quad corners;
  const Camera* camera = nullptr;  // as of KnownTagOptions
  bool is_rough = false;
};

// The power of light that a picture's grey levels are (TagFitOptions::gamma): the one with which
// the largest of its tags are fitted best. Blurred borders show it. 1 unless that is clearly worse.
double gamma_of_picture(const Image8& image, std::vector<TagInPicture> tags);

}  // namespace tagcal::internal
