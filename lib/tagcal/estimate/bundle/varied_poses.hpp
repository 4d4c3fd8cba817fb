#pragma once

#include <vector>

#include "tagcal/estimate/bundle/linked_poses.hpp"

namespace tagcal::internal {

// A pose that the solver varies, by a step from its start: omega (rad), and tau in units of the
// start's distance. Rotations and translations then have the same scale for the solver, whatever
// the unit of length is.
struct VariedPose {
  Pose reference;
  double length = 1;
  Vector6d step = Vector6d::Zero();

  explicit VariedPose(const Pose& start) : reference(start) {
    const double distance = start.translation().norm();
    if (distance > 0) length = distance;
  }

  Pose value() const {
    Vector6d scaled = step;
    scaled.tail<3>() *= length;
    return retract(reference, scaled);
  }

  // Derivatives by the step, from those by a step of `retract` at its value.
  template <typename Rows, typename Derived>
  void by_step(const Eigen::MatrixBase<Rows>& by_pose, Eigen::MatrixBase<Derived>& result) const {
    result.template leftCols<3>().noalias() =
        by_pose.template leftCols<3>().lazyProduct(left_jacobian(step.head<3>()));
    result.template rightCols<3>() = length * by_pose.template rightCols<3>();
  }
};

// The poses of cameras, instants and boards at the solver's current state. Vectors are never
// reallocated, because Ceres orders parameter blocks by their addresses.
struct VariedPoses {
  LinkedPoses& values;
  std::vector<VariedPose> cameras, instants, boards;

  explicit VariedPoses(LinkedPoses& poses)
      : values(poses),
        cameras(poses.camera_from_rig.begin(), poses.camera_from_rig.end()),
        instants(poses.rig_from_world.begin(), poses.rig_from_world.end()),
        boards(poses.world_from_board.begin(), poses.world_from_board.end()) {}

  void update() {
    const auto take = [](const std::vector<VariedPose>& from, std::vector<Pose>& to) {
      for (std::size_t i = 0; i < from.size(); ++i) to[i] = from[i].value();
    };
    take(cameras, values.camera_from_rig);
    take(instants, values.rig_from_world);
    take(boards, values.world_from_board);
  }
};

}  // namespace tagcal::internal
