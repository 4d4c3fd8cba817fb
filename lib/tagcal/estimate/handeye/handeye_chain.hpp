#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/handeye_types.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::internal {

// The places that a hand-eye calibration estimates, besides the robot's poses.
struct HandeyePlaces {
  Pose mount_from_camera, holder_from_board;
};

// The robot's pose between mount and holder (handeye_types.hpp).
inline Pose mount_from_holder(CameraMount mount, const Pose& base_from_hand) {
  return mount == CameraMount::base ? base_from_hand : base_from_hand.inverse();
}

inline Pose camera_from_board(const HandeyePlaces& places, CameraMount mount,
                              const Pose& base_from_hand) {
  return places.mount_from_camera.inverse() * mount_from_holder(mount, base_from_hand) *
         places.holder_from_board;
}

// The same pose with all lengths times a factor.
inline Pose with_lengths(const Pose& pose, double factor) {
  return {pose.rotation(), factor * pose.translation()};
}

// The robot's pose that the places predict from a view's own.
inline Pose base_from_hand(const HandeyePlaces& places, CameraMount mount,
                           const Pose& camera_from_board) {
  return mount_from_holder(  // its own inverse
      mount, places.mount_from_camera * camera_from_board * places.holder_from_board.inverse());
}

// The steps (`retract`) of camera_from_board by those of the two places and of base_from_hand, to
// first order.
struct HandeyeSteps {
  Matrix6 by_camera, by_board, by_robot;

  // With the translations of camera_from_board times `lengths`.
  HandeyeSteps(const HandeyePlaces& places, CameraMount mount, const Pose& base_from_hand,
               double lengths = 1);
};

// A view whose corners, with a noise of 1, determine its pose; or its pose alone, without corners.
struct HandeyeSight {
  ViewProblem corners;
  // The poses of the view alone, the likeliest first; without corners with their covariances.
  std::vector<SeenPose> own;
  Pose base_from_hand;  // as the robot says
  std::optional<RotationNumbers> rotation_numbers = std::nullopt;
  // The step of base_from_hand by the time of the view (1/s); zero without a path.
  Vector6d velocity = Vector6d::Zero();
};

// The products [J | r]'[J | r] of a view's residuals with J by its pose (`retract`) and by the
// lens, or what else all views share. Those of a view without corners are of its likeliest pose,
// whitened by its covariance. No value if a corner is outside of the lens' domain.
std::optional<Eigen::MatrixXd> products(const HandeyeSight& sight, const UncertainCamera& camera,
                                        const Pose& camera_from_board);

// How far the robot's poses are from what the pictures say.
struct HandeyeScale {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of the board's corners, in its frame
  double distance_m = 1;                             // median, from the camera
};

// Disagreement of a view: the root of the squared displacement of the board's centre and of the
// rotation, times the board's distance. An error of the robot's rotation counts alike in both.
double disagreement_m(const HandeyePlaces& places, CameraMount mount, const HandeyeScale& scale,
                      const Pose& camera_from_board, const Pose& base_from_hand);

}  // namespace tagcal::internal
