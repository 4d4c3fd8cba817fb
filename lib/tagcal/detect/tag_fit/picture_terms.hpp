#pragma once

#include <optional>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
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

// fit_known_tag() of a tag with its exact pattern and the terms of its picture, which replace those
// in the options. A tag that is clearly more like its exact pattern has not the print of the
// others.
std::optional<TagFit> fit_tag_with(const PictureTerms& terms, const ImageView8& image,
                                   const TagPattern& pattern, const Quad& start,
                                   TagFitOptions options, double reach_px = policy::kTagMaxMovePx);

}  // namespace tagcal::internal
