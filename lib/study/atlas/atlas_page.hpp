#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The page in Markdown: the definition of wrong, each map with its picture, three sentences and a
// table, the cells that miss the marks, the exemptions, and the place of each entry of the
// catalogue of failures. All its numbers come from the results.
std::string atlas_page(std::span<const AtlasSheet> sheets, std::span<const std::string> origin);

}  // namespace tagcal::study
