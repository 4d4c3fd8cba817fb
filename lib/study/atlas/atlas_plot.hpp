#pragma once

#include <span>
#include <string>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// The picture of a map as a script for gnuplot (5.4), which writes a PNG to its standard output:
// a panel for each method that is drawn, in each cell the shares of the four outcomes. `origin`
// stands below. 900 px wide, at twice that.
std::string atlas_picture(const StabilityMap& map, const StabilityResult& result,
                          std::span<const std::string> origin);

}  // namespace tagcal::study
