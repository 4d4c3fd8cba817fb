#pragma once

#include <string>

#include "study/atlas/stability.hpp"

namespace tagcal::study {

// A map's numbers as CSV, one row a cell and method:
//   map,x,y              the values of the axes, or names of kinds; y empty of a map with one
//   method,trials
//   right_and_said, wrong_and_said, wrong_and_silent, right_but_refused   numbers of trials
//   rms_over_bound       of the right answers, as a multiple of the Cramer-Rao bound; may be empty
//   median_over_bound    of all answers; may be empty
//   flips                likeliest answers nearer to the mirror image of a plane's pose
//   time_us              median processor time of one call
//   said                 "ok:2990 ambiguous:10"
//   first_silent, first_refused   the first trial wrong and silent, right but refused; may be empty
std::string stability_csv(const StabilityMap& map, const StabilityResult& result);

// The result of a complete run, without its seed. Throws Error for the numbers of another map.
StabilityResult read_stability(const StabilityMap& map, const std::string& text);

}  // namespace tagcal::study
