#include "tagcal/estimate/handeye/robot_advice.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

std::vector<Pose> camera_poses(const HandeyeScale& scale, double side) {
  std::vector<Pose> poses;
  constexpr double kTilts[] = {0, 0.45, 0.75};  // numeric: rad, candidates
  constexpr int kSides = 8, kTurns = 4;
  for (const double tilt : kTilts)
    for (int k = 0; k < (tilt > 0 ? kSides : 1); ++k)
      for (int turn = 0; turn < kTurns; ++turn) {
        const double azimuth = 2 * std::numbers::pi * k / kSides;
        const double roll = 2 * std::numbers::pi * turn / kTurns;
        const Vector3d eye =
            scale.centre +
            scale.distance_m *
                cartesian_from_spherical({1, tilt, azimuth}).cwiseProduct(Vector3d(1, 1, side));
        poses.push_back(
            rotation_about_z(roll) *
            camera_from_world_looking_at(eye, scale.centre,
                                         tilt > 0 ? Vector3d(0, 0, side) : Vector3d(0, 1, 0)));
      }
  return poses;
}

// A view of poses from there, as precise as the one from the most usual distance: its covariance
// about the board's centre is the same.
HandeyeProblem posed_from(const HandeyeProblem& problem, const Pose& pose) {
  const Vector3d& centre = problem.scale.centre;
  HandeyeProblem one = problem;
  one.sights = {*std::ranges::min_element(problem.sights, {}, [&](const HandeyeSight& s) {
    const double distance_m = (s.own[0].camera_from_target * centre).norm();
    return std::abs(distance_m - problem.scale.distance_m);
  })};
  SeenPose& seen = one.sights[0].own[0];
  Matrix6 by = Matrix6::Identity();
  by.bottomLeftCorner<3, 3>() =
      cross_matrix(pose.rotation() * centre - seen.camera_from_target.rotation() * centre);
  seen = {pose, by * seen.covariance * by.transpose()};
  return one;
}

// A problem of one view from there, with the corners of the view that has most. No value if one of
// them is outside of the image.
std::optional<HandeyeProblem> seen_from(const HandeyeProblem& problem, const Pose& pose) {
  const auto most = std::ranges::max_element(
      problem.sights, {}, [](const HandeyeSight& s) { return s.corners.correspondences.size(); });
  if (most->corners.correspondences.empty()) return posed_from(problem, pose);
  HandeyeProblem one = problem;
  one.sights = {*most};
  for (const Correspondence& c : one.sights[0].corners.correspondences) {
    const auto pixel = project(problem.camera.camera.lens, pose * c.point);
    if (!pixel || !contains(problem.camera.camera.image_size, *pixel)) return std::nullopt;
  }
  return one;
}

double largest_sigma(const MatrixXd& covariance, Eigen::Index first) {
  const Matrix3d block = covariance.block<3, 3>(first, first);
  return std::sqrt(block.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
}

// The hand stays near where it has been.
bool is_near(const HandeyeState& state, const Pose& base_from_hand) {
  Vector3d mean = Vector3d::Zero();
  for (const Pose& p : state.base_from_hand)
    mean += p.translation() / static_cast<double>(state.base_from_hand.size());
  double reach = 0;
  for (const Pose& p : state.base_from_hand)
    reach = std::max(reach, (p.translation() - mean).norm());
  constexpr double kFurther = 1.5, kLeastReach = 0.2;  // numeric: what is proposed, not decided
  return (base_from_hand.translation() - mean).norm() <= std::max(kFurther * reach, kLeastReach);
}

std::string sentence_of(const AdvisedRobotPose& next) {
  const Vector3d t = next.base_from_hand.translation();
  const Eigen::Quaterniond q = next.base_from_hand.rotation();
  return fmt::format(
      "move the hand to x {:.3f} y {:.3f} z {:.3f} m, quaternion w {:.3f} x {:.3f} y {:.3f} z "
      "{:.3f}: the camera's place is then known to {:.2g} mm and {:.2g} deg (now {:.2g} mm, {:.2g} "
      "deg)",
      t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z(), 1e3 * next.sigma_m, degrees(next.sigma_rad),
      1e3 * next.sigma_now_m, degrees(next.sigma_now_rad));
}

}  // namespace

std::optional<AdvisedRobotPose> advise_robot_pose(const HandeyeProblem& problem,
                                                  const HandeyeState& state,
                                                  const RobotNoise& noise,
                                                  const HandeyeEstimate& answer) {
  const auto now = HandeyeEquations::at(problem, state);
  const auto solved = now ? now->solve(noise) : std::nullopt;
  if (!solved) return std::nullopt;
  const MatrixXd information = solved->covariance.inverse();
  const Pose typical = camera_from_board(state.places, problem.mount, state.base_from_hand[0]);
  const double side = (typical.inverse().translation() - problem.scale.centre).z() > 0 ? 1 : -1;
  std::optional<AdvisedRobotPose> best;
  double least = solved->covariance.topLeftCorner<6, 6>().determinant();
  for (const Pose& pose : camera_poses(problem.scale, side)) {
    const Pose hand = base_from_hand(state.places, problem.mount,
                                     with_lengths(pose, std::exp(state.log_board_scale)));
    auto one = seen_from(problem, pose);
    if (!one || !is_near(state, hand)) continue;
    one->board_scale_sigma = policy::kFreeScale;  // its prior counts once
    const auto view = HandeyeEquations::at(
        *one, {state.places, {hand}, state.time_offset_s, state.log_board_scale});
    const auto added = view ? view->solve(noise) : std::nullopt;
    if (!added) continue;
    const MatrixXd after = (information + added->covariance.inverse()).inverse();
    const double volume = after.topLeftCorner<6, 6>().determinant();
    if (!(volume < least)) continue;
    least = volume;
    const double now_m = largest_sigma(answer.camera_covariance, 3);
    const double now_rad = largest_sigma(answer.camera_covariance, 0);
    best = {hand,
            now_m,
            now_m * largest_sigma(after, 3) / largest_sigma(solved->covariance, 3),
            now_rad,
            now_rad * largest_sigma(after, 0) / largest_sigma(solved->covariance, 0),
            ""};
  }
  if (best) best->sentence = sentence_of(*best);
  return best;
}

}  // namespace tagcal::internal
