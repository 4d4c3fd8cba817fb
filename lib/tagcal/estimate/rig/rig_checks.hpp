#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/rig/rig_start.hpp"

namespace tagcal::internal {

// The instants of most neighbours are near enough to one another to tell an offset by a number
// (policy::kOffsetGap), or have no stamps.
bool tells_offset(const RigState& state);

// The offset of a camera's clock, and its place, that explain its disagreements with a trajectory
// best. It is off if that is significant (policy::kOutlierSigmas, by the disagreements that
// remain), moves the corners by more than policy::kGoodCornerPx, and explains more than a move of
// the camera (camera_move). No value if the trajectory is known at the times of too few views, or
// no offset near the start is the best.
struct ClockFit {
  ClockOffset clock;
  Pose camera_from_rig;
  bool is_off = false;
};
std::optional<ClockFit> fit_clock(const RigState& state, std::size_t camera,
                                  const Trajectory& trajectory, const Connected& connected,
                                  const Pose& camera_from_rig, double offset);

// The instant from which on a camera is at another place, and by how much: the split of its
// disagreements into two places that explains them best, if it is significant, as above.
struct CameraMove {
  std::size_t camera = 0;
  std::size_t instant = 0;           // the first one at the new place
  Vector6d step = Vector6d::Zero();  // from the old place to the new one (`retract`)
  double rest = 0;                   // the disagreements' squares that remain, over their freedom
};
std::optional<CameraMove> camera_move(const RigState& state, std::size_t camera,
                                      const Trajectory& trajectory, const Connected& connected);

// The place of a camera by a linear fit of its disagreements alone, as a step from its place, and
// the covariance of that by what remains.
struct PlaceOfPair {
  Vector6d step = Vector6d::Zero();
  Matrix6 covariance = Matrix6::Zero();
};
std::optional<PlaceOfPair> place_of(std::span<const Disagreement> disagreements,
                                    const RigState& state, std::size_t camera);

}  // namespace tagcal::internal
