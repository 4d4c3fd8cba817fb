#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/handeye/handeye_start.hpp"

namespace tagcal::internal {

// Another reading of the robot's poses that fits much better than the given one (policy), the best
// one: inverse, another unit of length, another order of quaternion or angles, and these together;
// or the poses of neighbouring views, which is `is_shift`.
struct BetterReading {
  RobotReading reading;
  bool is_shift = false;
};
std::optional<BetterReading> better_reading(std::span<const HandeyePair> views, CameraMount mount,
                                            const HandeyeScale& scale);

}  // namespace tagcal::internal
