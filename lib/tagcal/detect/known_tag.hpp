#pragma once

#include <optional>

#include "tagcal/detect/refine_edges.hpp"
#include "tagcal/detect/refine_tag.hpp"

// Private to detect.
namespace tagcal {

// The fit of a whole tag that is known to be there, its corners to 2 px: what lies further away is
// another answer. Under the camera's lens, if one is given, which may be known roughly only. No
// value where it does not converge.
std::optional<TagFit> fit_known_tag(const Image8& image, const TagPattern& pattern,
                                    const Quad& start, const Camera* camera, bool is_rough = false);

}  // namespace tagcal
