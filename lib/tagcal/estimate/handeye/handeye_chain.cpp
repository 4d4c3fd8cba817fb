#include "tagcal/estimate/handeye/handeye_chain.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/linked_poses.hpp"

namespace tagcal::internal {

// With C = X^-1 M Y, the pose of a point p in C is R_X' (M Y p - t_X): a step (omega, tau) of the
// inverted X is that of C, turned to the camera and with the opposite sign, about the point that it
// moves. With the camera on the hand M is inverted, too.
HandeyeSteps::HandeyeSteps(const HandeyePlaces& places, CameraMount mount,
                           const Pose& base_from_hand, double lengths) {
  const Pose m = mount_from_holder(mount, base_from_hand);
  const Eigen::Matrix3d camera_from_mount = places.mount_from_camera.rotation_matrix().transpose();
  const Eigen::Matrix3d camera_from_holder = camera_from_mount * m.rotation_matrix();
  const Eigen::Vector3d& board = places.holder_from_board.translation();
  by_camera = -step_by(camera_from_mount, m * board - places.mount_from_camera.translation());
  by_board = step_by(camera_from_holder, Eigen::Vector3d::Zero());
  if (mount == CameraMount::base)
    by_robot = step_by(camera_from_mount, m.rotation_matrix() * board);
  else
    by_robot = -step_by(camera_from_holder, board - base_from_hand.translation());
  for (Matrix6* const by : {&by_camera, &by_board, &by_robot}) by->bottomRows<3>() *= lengths;
}

// Residual r = minus(pose, own) with J = 1, to first order, and J_l = -(response of `own`).
std::optional<Eigen::MatrixXd> products(const HandeyeSight& sight, const UncertainCamera& camera,
                                        const Pose& camera_from_board) {
  const Eigen::Index shared = camera.covariance.cols();
  if (sight.corners.correspondences.empty()) {
    const SeenPose& own = sight.own.front();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, 7 + shared);
    rows.leftCols<6>().setIdentity();
    if (own.response.size() > 0) rows.middleCols(6, shared) = -own.response;
    rows.rightCols<1>() = minus(camera_from_board, own.camera_from_target);
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(own.covariance);
    rows = llt.matrixL().solve(rows).eval();
    return Eigen::MatrixXd(rows.transpose() * rows);
  }
  const auto free = shared > 0 ? camera.model->free() : std::span<const FreeParameter>();
  const auto upper = products_of(sight.corners, free, camera.camera.lens, camera_from_board);
  if (!upper) return std::nullopt;
  return Eigen::MatrixXd(upper->selfadjointView<Eigen::Upper>());
}

double disagreement_m(const HandeyePlaces& places, CameraMount mount, const HandeyeScale& scale,
                      const Pose& seen, const Pose& base_from_hand) {
  const Pose by_robot = camera_from_board(places, mount, base_from_hand);
  return std::hypot((by_robot * scale.centre - seen * scale.centre).norm(),
                    scale.distance_m * angle_between_rad(by_robot, seen));
}

}  // namespace tagcal::internal
