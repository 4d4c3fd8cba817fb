#pragma once

#include <vector>

#include "tagcal/estimate/rig/rig_solve.hpp"

namespace tagcal::internal {

// Takes lenses, places and poses from a first bundle: a camera's own lens may be known badly.
void take_first_bundle(RigState& state, const RigOptions& options);

// The clocks that are off, with the offsets by which they would be corrected.
std::vector<ClockOffset> find_clocks_off(const RigOptions& options, const RigState& state,
                                         const RigStart& start);

// Finds one offset a camera, and moves the world of each view from its instant to the time of the
// view by its clock, as the other cameras saw it move; views at times that they do not tell are
// taken out of their instants. It does so under the lenses of a bundle in which the clocks are
// corrected: others are bent by the offsets, which are then found too small.
std::vector<ClockFit> correct_clocks_and_lenses(const RigOptions& options, RigState& state,
                                                RigStart& start);

}  // namespace tagcal::internal
