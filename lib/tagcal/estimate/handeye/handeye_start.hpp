#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/handeye/handeye_chain.hpp"

namespace tagcal::internal {

// Poses of a board and of the hand at the same time.
struct HandeyePair {
  Pose camera_from_board;
  Pose base_from_hand;
  std::optional<RotationNumbers> rotation_numbers = std::nullopt;
};

struct HandeyeStart {
  HandeyePlaces places;
  std::vector<double> disagreements_m;  // by view
  double rms_m = 0;
};

// Places in closed form from all views: from their motions (motion_start) or, if that fits better,
// from the directions of their translations, as those of a hand that does not turn. No value for
// fewer than three views, and for views that are all the same.
std::optional<HandeyeStart> closed_form_places(std::span<const HandeyePair> views,
                                               CameraMount mount, const HandeyeScale& scale);

// The same from the half of the views that agrees best, marked in `takes_part`. Fewer views than
// policy::kFewestConsensus all take part.
struct RobustHandeyeStart {
  HandeyePlaces places;
  std::vector<std::uint8_t> takes_part;
};
std::optional<RobustHandeyeStart> robust_places(std::span<const HandeyePair> views,
                                                CameraMount mount, const HandeyeScale& scale);

}  // namespace tagcal::internal
