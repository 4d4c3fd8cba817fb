#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The page in Markdown: what counts as wrong, each map with its picture, three sentences and a
// table, the cells that miss the marks, what is exempt, and where each entry of the catalogue of
// failures has its place. Every number in it is from the results.
std::string atlas_page(std::span<const AtlasSheet> sheets, std::span<const std::string> origin);

}  // namespace tagcal::study
