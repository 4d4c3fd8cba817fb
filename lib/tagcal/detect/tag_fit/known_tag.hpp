#pragma once

#include <optional>

#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/detect/tag_fit/refine_edges.hpp"

// Private to detect.
namespace tagcal::internal {

struct KnownTagOptions {
  const Camera* camera = nullptr;  // under whose lens tags are fitted, if one is given ..
  bool is_rough = false;           // .. which may be known roughly only
  double gamma = 1;                // of the grey levels
  bool is_whole = false;           // as of TagFitOptions
};

// The fit of a whole tag that is known to be there, its corners to 2 px: what lies further away is
// another answer. No value where it does not converge.
std::optional<TagFit> fit_known_tag(const Image8& image, const TagPattern& pattern,
                                    const Quad& start, const KnownTagOptions& known);

}  // namespace tagcal::internal
