#pragma once

#include <span>
#include <string>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The picture of a map as a script for gnuplot (5.4), which writes a PNG to its standard output:
// one panel for each drawn method, in each cell the shares of the four outcomes, and `origin`
// below. The layout is 900 px wide, the PNG twice as wide.
std::string atlas_picture(const StabilityMap& map, const StabilityResult& result,
                          std::span<const std::string> origin);

}  // namespace tagcal::study
