#pragma once

#include <optional>

#include "tagcal/detect/refine.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

// The options with the prior of shifts and bends in a picture of the given size: lenses bend lines
// in proportion to the picture.
TagFitOptions with_usual_priors(TagFitOptions options, const ImageSize& size);

// Fits a whole tag whose corners are known to `reach_px`, with the usual priors. No value if the
// fit does not converge (unless the corners are approximate, as asked for), or ends farther away,
// which is another minimum.
std::optional<TagFit> fit_known_tag(const ImageView8& image, const TagPattern& pattern,
                                    const Quad& start, const TagFitOptions& options,
                                    double reach_px = policy::kTagMaxMovePx);

}  // namespace tagcal::internal
