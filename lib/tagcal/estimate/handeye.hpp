#pragma once

#include <optional>
#include <span>
#include <string>

#include "tagcal/estimate/handeye_types.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/estimate/view_correspondences.hpp"

namespace tagcal {

// A picture of the board, and where the robot says its hand was.
struct HandeyeView {
  std::string image;         // for people
  ViewCorrespondences seen;  // in the frame of the board
  Pose base_from_hand;
  std::optional<double> time_s;  // on the camera's clock; for HandeyeOptions::path
  // In place of the corners, for calibrate_handeye_from_poses: the board's pose, or two, the
  // likeliest first.
  std::vector<SeenPose> poses = {};
  std::vector<Finding> findings = {};  // without a pose: why
  // The rotation as HandeyeOptions::robot_form; no value: not known, or of a path.
  std::optional<RotationNumbers> rotation_numbers = std::nullopt;
};

// Where a camera is on a robot's hand (or beside the robot), and where the board is, from views of
// a board at rest (or in the hand) and the robot's poses:
//   camera_from_board = mount_from_camera^-1 * mount_from_holder * holder_from_board.
// Steps:
//   1. the pose of each view (estimate_pose);
//   2. a start from the motions between all pairs of views, rotations before translations (Park &
//      Martin 1994), robust: by the least trimmed squares over triples of views;
//   3. other readings of the robot's poses (inverse, units, order of the quaternion, ..), which are
//      proposed if they fit much better;
//   4. one bundle in pixels over both places and all robot poses, which have normal errors about
//      what the robot says. The standard deviations of these are estimated with them (restricted
//      maximum likelihood: Patterson & Thompson, Biometrika 1971), so that claims do not rest on a
//      data sheet;
//   5. the joint covariance: of corners, robot, lens; wider for few degrees of freedom.
// Statuses: ok; rotation_axes_parallel; no_rotation; wrong_direction; not_synchronous; degenerate
// (fewer than three different poses, or too few for their noise); no_consensus, if more than a
// third of the robot's poses contradict the others; not_converged. Throws Error for a number that
// is not finite, a path with times that do not increase or views without times, and a covariance of
// the lens that does not fit its model.
HandeyeEstimate calibrate_handeye(std::span<const HandeyeView> views, const UncertainCamera& camera,
                                  const HandeyeOptions& options = {});

// The same from poses of the board that another program or a rig estimated (HandeyeView::poses), by
// the same bundle: the squared residuals of a view are those of its pose, by its covariance.
// `shared` is the covariance of the parameters that all poses share (SeenPose::response), as
// KnownRig::covariance; empty: the poses' errors are independent. The camera of the answer is, of a
// rig, its frame; rms_px and sigma_px are NaN. Throws Error for a covariance that is not positive
// definite, and for responses that do not fit `shared`.
HandeyeEstimate calibrate_handeye_from_poses(std::span<const HandeyeView> views,
                                             const MatrixX& shared = {},
                                             const HandeyeOptions& options = {});

}  // namespace tagcal
