#pragma once

#include <optional>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

// Private to detect.
namespace tagcal::internal {

struct KnownTagOptions {
  const Camera* camera = nullptr;  // tags are fitted under its lens, if one is given
  bool is_rough = false;           // the camera is only roughly known
  double gamma = 1;                // of the grey levels
  bool is_whole = false;           // as in TagFitOptions
  bool lens_follows = false;       // as in TagFitOptions
};

// The prior of shifts and bends in a picture of the given size: lenses bend lines in proportion to
// the picture.
TagFitOptions usual_fit_options(const ImageSize& size);

// Fits a whole tag whose corners are known to 2 px. No value if the fit does not converge (unless
// the corners are approximate, as asked for), or ends farther away, which is another minimum.
std::optional<TagFit> fit_known_tag(const ImageView8& image, const TagPattern& pattern,
                                    const Quad& start, const KnownTagOptions& known);

}  // namespace tagcal::internal
