#pragma once

#include <span>
#include <string>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The known failures of geometry (G), models (M) and data (D), and where each has its place: a map,
// an exemption with its reason, or neither. Markdown; maps that are on the page are linked.
std::string catalogue_text(std::span<const AtlasSheet> sheets);

}  // namespace tagcal::study
