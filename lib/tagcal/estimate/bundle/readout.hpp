#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::internal {

// The velocity of the target in the camera of a view, a twist (rad/s, m/s), from the poses of its
// neighbours in time; no value if it has fewer than two. `poses`: camera_from_target.
std::vector<std::optional<Vector6d>> velocities_in_time(std::span<const double> times_s,
                                                        std::span<const Pose> poses);

// The readout of a rolling shutter, by a Gauss-Newton step of all parameters of a solved bundle
// from none: each row of a picture is displaced by readout / height times the velocity of its view.
// No value if no view has neighbours, or none moves. `times_s`: of each view of the bundle.
std::optional<Readout> readout_of(const Bundle& solved, std::span<const double> times_s);

}  // namespace tagcal::internal
