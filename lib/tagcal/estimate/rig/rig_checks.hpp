#pragma once

#include <optional>
#include <span>

#include "tagcal/estimate/rig/rig_start.hpp"

namespace tagcal::internal {

// How the world moves in the rig at an instant, in the unit of RigState::time: the parabola through
// the instants before and after. No value without them, or if they are further apart than
// policy::kLongestGap.
struct WorldMotion {
  Vector6d velocity, acceleration;

  // The step (`retract`) after a time.
  Vector6d after(double time) const { return time * velocity + time * time / 2 * acceleration; }
};
std::optional<WorldMotion> motion_at(const RigState& state, std::size_t instant,
                                     const Trajectory& trajectory);

// The instants of most neighbours are near enough to one another to tell an offset by a number
// (policy::kOffsetGap), or have no stamps.
bool tells_offset(const RigState& state);

// The offset of a camera's clock that explains its disagreements with a trajectory best, to first
// order. It is off if that is significant (policy::kOutlierSigmas, by the disagreements that
// remain) and moves the corners by more than policy::kGoodCornerPx. No value if too few instants
// have a velocity.
struct ClockFit {
  ClockOffset clock;
  bool is_off = false;
};
std::optional<ClockFit> fit_clock(const RigState& state, std::size_t camera,
                                  const Trajectory& trajectory, const Connected& connected);

// The instant from which on a camera is at another place, and by how much: the split of its
// disagreements into two places that explains them best, if it is significant, as above.
struct CameraMove {
  std::size_t camera = 0;
  std::size_t instant = 0;           // the first one at the new place
  Vector6d step = Vector6d::Zero();  // from the old place to the new one (`retract`)
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
