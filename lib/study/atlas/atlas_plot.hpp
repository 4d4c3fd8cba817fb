#pragma once

#include <span>
#include <string>

#include "study/atlas/stability.hpp"
#include "study/plot/drawing.hpp"

namespace tagcal::study {

// The picture of a map: one panel for each drawn method, in each cell the shares of the four
// outcomes, and `origin` below. 900 px wide.
Drawing atlas_picture(const StabilityMap& map, const StabilityResult& result,
                      std::span<const std::string> origin);

}  // namespace tagcal::study
