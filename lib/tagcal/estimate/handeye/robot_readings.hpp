#pragma once

#include <functional>
#include <optional>
#include <span>

#include "tagcal/estimate/handeye/handeye_start.hpp"

namespace tagcal::internal {

// The reading of the robot's poses that fits best, if it is not the given one: inverse, another
// unit of length, another form or order of the rotation, and these together; or the poses of
// neighbouring views, which is `is_shift`. Readings are tried that the form of the poses allows.
// `is_certain`: it fits much better (policy) than with fewer changes, not by chance, and as well as
// an answer has to. The closed form is poor for few views or axes that are nearly parallel: bundles
// decide the rest.
struct BetterReading {
  RobotReading reading;
  std::function<Pose(const HandeyePair&)> read;  // base_from_hand; none of a shift
  bool is_shift = false;
  bool is_certain = false;
};
std::optional<BetterReading> better_reading(std::span<const HandeyePair> views, CameraMount mount,
                                            const HandeyeScale& scale, const RobotForm& form = {});

// True if the disagreements of that many views can show that another reading fits much better.
bool can_show_reading(std::size_t num_views);

}  // namespace tagcal::internal
