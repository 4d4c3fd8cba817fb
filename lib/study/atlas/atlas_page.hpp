#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/atlas/stability.hpp"
#include "study/plot/drawing.hpp"

namespace tagcal::study {

// The picture of a map: one panel for each drawn method, in each cell the shares of the four
// outcomes, and `origin` below. 900 px wide.
Drawing atlas_picture(const StabilityMap& map, const StabilityResult& result,
                      std::span<const std::string> origin);

// The page in Markdown: the definition of wrong, each map with its picture, three sentences and a
// table, the cells that miss the marks, the exemptions, and the place of each entry of the
// catalogue of failures. All its numbers come from the results.
std::string atlas_page(std::span<const AtlasSheet> sheets, std::span<const std::string> origin);

}  // namespace tagcal::study
