#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/handeye/handeye_bundle.hpp"
#include "tagcal/estimate/handeye/handeye_start.hpp"

namespace tagcal::internal {

// The bundle from places, with a start of the robot's noise from the views' own poses.
std::optional<HandeyeMinimum> bundle_of(const HandeyeProblem& problem, const HandeyePlaces& places);

// The bundle of the views whose robot poses agree. The views of the start grow, by those that agree
// best, to all that agree with their bundle, and then those that contradict the bundle of the
// others are rejected (policy::kSignificant; Hadi & Simonoff, J. Am. Stat. Assoc. 88, 1264 (1993)):
// outliers that inflate the noise of a bundle of all views cannot mask one another. All of fewer
// than policy::kFewestConsensus views, and all if none are to be rejected.
struct HandeyeConsensus {
  HandeyeMinimum minimum;
  std::vector<std::uint8_t> takes_part;  // by sight
};
std::optional<HandeyeConsensus> find_consensus(const HandeyeProblem& problem,
                                               const RobustHandeyeStart& start, bool rejects);

}  // namespace tagcal::internal
