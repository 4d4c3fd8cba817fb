#pragma once

#include <span>
#include <string>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The known failures of geometry (G), models (M) and data (D) in Markdown, each with its map, the
// reason of its exemption, or neither. Maps that are on the page are linked.
std::string catalogue_text(std::span<const AtlasSheet> sheets);

}  // namespace tagcal::study
