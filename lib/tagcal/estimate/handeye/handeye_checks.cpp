#include "tagcal/estimate/handeye/handeye_checks.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Principal standard deviations of a block of a covariance, ascending, with their axes.
struct Principal {
  Vector3d sigma;
  Matrix3d axes;
  explicit Principal(const Matrix3d& covariance) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(covariance);
    sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
    axes = eigen.eigenvectors();
  }
};

std::string axis_text(Vector3d axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  constexpr double kShown = 0.005;  // numeric: shown as 0.00 without a sign
  for (double& x : axis)
    if (std::abs(x) < kShown) x = 0;
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", axis.x(), axis.y(), axis.z());
}

const char* mount_name(CameraMount mount) { return mount == CameraMount::hand ? "hand" : "base"; }

}  // namespace

void check_path(const RobotPath& path) {
  if (path.times_s.size() != path.base_from_hand.size())
    throw Error(fmt::format("the path has {} times and {} poses", path.times_s.size(),
                            path.base_from_hand.size()));
  for (std::size_t i = 0; i < path.times_s.size(); ++i) {
    if (!path.base_from_hand[i].matrix().allFinite())
      throw Error(fmt::format("path: pose {} has a number that is not finite", i));
    if (!std::isfinite(path.times_s[i]) || (i > 0 && !(path.times_s[i] > path.times_s[i - 1])))
      throw Error(fmt::format("path: times must increase, time {} does not", i));
  }
}

void check_seen_pose(const SeenPose& pose, Eigen::Index num_shared, const std::string& name) {
  const Eigen::Matrix<double, 6, 6> covariance = pose.covariance;
  const bool is_positive = covariance.allFinite() && covariance_defect(covariance).empty() &&
                           covariance.llt().info() == Eigen::Success;
  if (!is_positive || !pose.camera_from_target.matrix().allFinite())
    throw Error(name + ": the pose must be finite, and its covariance positive definite");
  if (pose.response.size() > 0 && (pose.response.rows() != 6 || pose.response.cols() != num_shared))
    throw Error(fmt::format("{}: the response of the pose must be 6 x {}, got {} x {}", name,
                            num_shared, pose.response.rows(), pose.response.cols()));
}

double AxisSpread::spread_rad() const { return std::atan2(rms_rad[1], rms_rad[0]); }

AxisSpread axis_spread(std::span<const Pose> poses) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Pose& p : poses) sum += p.rotation_matrix();
  AxisSpread spread;
  // Views in opposite directions have a mean of rank 1 or 0.
  constexpr double kFlat = 1e-6;  // numeric: any mean will do
  const Vector3d size = sum.jacobiSvd().singularValues();
  const Eigen::Quaterniond mean = size[1] > kFlat * static_cast<double>(poses.size())
                                      ? nearest_rotation(sum)
                                      : poses.front().rotation();
  Matrix3d scatter = Matrix3d::Zero();
  for (const Pose& p : poses) {
    const Vector3d v = log_rotation(p.rotation() * mean.conjugate());
    scatter += v * v.transpose() / static_cast<double>(poses.size());
  }
  const Principal principal(scatter);
  spread.rms_rad = principal.sigma.reverse();
  spread.in_camera = principal.axes.rowwise().reverse();
  return spread;
}

double widening(double degrees_of_freedom) {
  constexpr int kParameters = 6;         // of a pose
  constexpr double kQuantile95 = 1.645;  // numeric: of the normal distribution, one-sided
  constexpr double kLeast = 1.0;         // of freedoms: below, F has no width to speak of
  constexpr int kHalvings = 40;          // numeric: bisection to the last digits
  const double freedoms = std::max(kLeast, degrees_of_freedom);
  double low = 1, high = 1e4;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low * high);
    (variance_ratio_score(middle, kParameters, freedoms) < kQuantile95 ? low : high) = middle;
  }
  return std::max(1.0, low * kParameters / chi_square_quantile(kParameters, kQuantile95));
}

double sigma_of_log_scale(const HandeyeMinimum& minimum) {
  return std::sqrt(widening(minimum.degrees_of_freedom) *
                   minimum.covariance(HandeyeEquations::kScale, HandeyeEquations::kScale));
}

bool is_beyond_prior(const HandeyeMinimum& minimum, double prior_sigma) {
  return std::abs(minimum.state.log_board_scale) >
         policy::kSignificant * std::hypot(prior_sigma, sigma_of_log_scale(minimum));
}

void add_board_scale(HandeyeEstimate& answer) {
  add(answer.findings, code::board_scale,
      fmt::format(
          "by the robot's lengths the board is {} than its file says, by {} %: measure the "
          "board, or the robot's lengths have another unit. The answer has the robot's "
          "lengths",
          answer.board_scale > 1 ? "larger" : "smaller",
          with_sigma(100 * std::abs(answer.board_scale - 1), 100 * answer.sigma_board_scale)));
}

void check_determined(const AxisSpread& axes, const HandeyeScale& scale, HandeyeEstimate& answer) {
  const Principal place(answer.camera_covariance.bottomRightCorner<3, 3>());
  const Principal turn(answer.camera_covariance.topLeftCorner<3, 3>());
  const double most = policy::kHandeyeRefused * scale.distance_m;
  const auto unknown = (place.sigma.array() > most).count();
  const bool unknown_turn = turn.sigma[2] > policy::kHandeyeRefusedRad;
  if (unknown == 0 && !unknown_turn) return;
  const char* const mount = mount_name(answer.mount);
  if (axes.rms_rad[0] < policy::kLeastHandeyeTurn) {
    add(answer.findings, code::no_rotation,
        fmt::format("the camera turns by {:.2g} deg from view to view (RMS): its translation in "
                    "the {} is unknown. Turn the hand by 30 degrees or more, about two axes",
                    degrees(axes.rms_rad[0]), mount));
  } else if (axes.spread_rad() < policy::kLeastAxisSpread) {
    const Vector3d axis = answer.mount_from_camera.rotation() * axes.in_camera.col(0);
    add(answer.findings, code::rotation_axes_parallel,
        fmt::format("all rotations are about one axis, {} in the {} (spread {:.2g} deg): the "
                    "camera's place along it is unknown (sd {:.2g} m). Turn the hand about "
                    "another axis, too, by 30 degrees or more",
                    axis_text(axis), mount, degrees(axes.spread_rad()), place.sigma[2]));
  } else {
    add(answer.findings, code::degenerate,
        fmt::format("the poses do not determine the camera in the {}: sd {:.2g} m and {:.2g} deg. "
                    "Take more poses, turned by 30 degrees or more about different axes",
                    mount, place.sigma[2], degrees(turn.sigma[2])));
  }
}

}  // namespace tagcal::internal
