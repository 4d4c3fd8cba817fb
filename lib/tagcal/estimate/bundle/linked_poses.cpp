#include "tagcal/estimate/bundle/linked_poses.hpp"

namespace tagcal::internal {

Matrix6 step_by(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& arm) {
  Matrix6 step = Matrix6::Zero();
  step.topLeftCorner<3, 3>() = rotation;
  step.bottomRightCorner<3, 3>() = rotation;
  step.bottomLeftCorner<3, 3>() = -rotation * cross_matrix(arm);
  return step;
}

// With P = X M Y Z the origin of the board is at t_X + R_X (t_M + R_M (t_Y + R_Y t_Z)): a
// rotation omega of a part moves it by omega x (the part of that sum that it turns).
LinkedSteps::LinkedSteps(const LinkedPoses& poses, std::size_t camera,
                         const LinkedPoses::Link& link) {
  const Pose& x = poses.camera_from_rig[camera];
  const Pose& y = poses.rig_from_world[link.instant];
  const Pose& z = poses.world_from_board[link.board];
  const Eigen::Vector3d board_in_rig = y * z.translation();
  const Eigen::Matrix3d camera_from_rig = x.rotation_matrix();
  const Eigen::Matrix3d camera_from_moved = camera_from_rig * link.motion.rotation_matrix();
  by_camera = step_by(Eigen::Matrix3d::Identity(), camera_from_rig * (link.motion * board_in_rig));
  by_instant = step_by(camera_from_moved, board_in_rig - y.translation());
  by_board = step_by(camera_from_moved * y.rotation_matrix(), Eigen::Vector3d::Zero());
}

}  // namespace tagcal::internal
