#include "tagcal/estimate/handeye/handeye_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/handeye/robot_readings.hpp"
#include "tagcal/estimate/policy/handeye_policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

void report_places(const HandeyeMinimum& minimum, HandeyeEstimate& answer) {
  answer.mount_from_camera = minimum.state.places.mount_from_camera;
  answer.holder_from_board = minimum.state.places.holder_from_board;
  answer.degrees_of_freedom = minimum.degrees_of_freedom;
  const Eigen::MatrixXd covariance = widening(minimum.degrees_of_freedom) * minimum.covariance;
  answer.covariance = covariance.topLeftCorner<12, 12>();
  answer.camera_covariance = covariance.topLeftCorner<6, 6>();
  answer.board_covariance = covariance.block<6, 6>(6, 6);
  answer.board_scale = std::exp(minimum.state.log_board_scale);
  answer.sigma_board_scale = answer.board_scale * sigma_of_log_scale(minimum);
  const RobotNoise& noise = minimum.noise.noise;
  answer.robot_sigma_rad = noise.sigma_rad;
  answer.robot_sigma_m = noise.sigma_m;
  answer.robot_sigma_rad_share = std::sqrt(minimum.noise.log_covariance(0, 0));
  answer.robot_sigma_m_share = std::sqrt(minimum.noise.log_covariance(1, 1));
}

double rms_px(const HandeyeSight& sight, const Lens& lens, const Pose& camera_from_board) {
  const auto& corners = sight.corners.correspondences;
  if (corners.empty()) return std::nan("");
  double squares = 0;
  for (const Eigen::Vector2d& r :
       residuals_px({corners.data(), corners.size()}, lens, camera_from_board))
    squares += r.squaredNorm();
  return std::sqrt(squares / static_cast<double>(corners.size()));
}

HandeyeViewFit fit_of(const HandeyeSights& sights, const HandeyeMinimum& minimum, std::size_t i) {
  const HandeyeProblem& problem = sights.problem();
  const Vector6d error = robot_error(problem, minimum.state, i);
  HandeyeViewFit fit;
  fit.view = sights.view_of(i);
  fit.base_from_hand = minimum.state.base_from_hand[i];
  fit.error_rad = error.head<3>().norm();
  fit.error_m = error.tail<3>().norm();
  fit.score = std::sqrt(error.cwiseAbs2().dot(minimum.noise.noise.weights()) / 6);
  fit.rms_px = rms_px(problem.sights[i], problem.camera.camera.lens,
                      camera_from_board(problem, minimum.state, i));
  return fit;
}

double spread_m(const HandeyeProblem& problem, const HandeyeState& state) {
  std::vector<Vector3d> centres;
  Vector3d mean = Vector3d::Zero();
  const auto n = static_cast<double>(problem.sights.size());
  for (const HandeyeSight& s : problem.sights) {
    const Pose holder_from_mount = mount_from_holder(problem.mount, s.base_from_hand).inverse();
    const Vector3d in_camera =
        std::exp(state.log_board_scale) * (s.own[0].camera_from_target * problem.scale.centre);
    centres.push_back(holder_from_mount * (state.places.mount_from_camera * in_camera));
    mean += centres.back() / n;
  }
  double squares = 0;
  for (const Vector3d& c : centres) squares += (c - mean).squaredNorm() / n;
  return std::sqrt(squares);
}

void report_views(const HandeyeSights& sights, const HandeyeMinimum& minimum,
                  HandeyeEstimate& answer) {
  double squares = 0;
  for (std::size_t i = 0; i < sights.problem().sights.size(); ++i) {
    answer.views.push_back(fit_of(sights, minimum, i));
    const auto n = static_cast<int>(sights.problem().sights[i].corners.correspondences.size());
    answer.num_corners += n;
    squares += n * std::pow(answer.views.back().rms_px, 2);
  }
  answer.rms_px = std::sqrt(squares / answer.num_corners);
  answer.board_spread_m = spread_m(sights.problem(), minimum.state);
}

// The first views that were rejected.
std::string names_of_rejected(const HandeyeSights& sights, const HandeyeEstimate& answer) {
  constexpr std::size_t kNamed = 6;  // numeric: what is printed
  std::string names;
  for (std::size_t i = 0; i < std::min(kNamed, answer.rejected.size()); ++i)
    names += (i > 0 ? ", " : "") + sights.image_of(answer.rejected[i]);
  return answer.rejected.size() > kNamed ? names + ", .." : names;
}

void add_warnings(const HandeyeSights& sights, HandeyeEstimate& answer) {
  if (!answer.rejected.empty())
    add(answer.findings, code::view_rejected,
        fmt::format(
            "the robot's poses of {} of {} views contradict the others and are not used: {}",
            answer.rejected.size(), answer.rejected.size() + answer.views.size(),
            names_of_rejected(sights, answer)));
  if (answer.degrees_of_freedom < policy::kFewRobotFreedoms ||
      !can_show_reading(answer.views.size()))
    add(answer.findings, code::few_views,
        fmt::format("{} poses hardly tell the robot's noise ({:.1f} degrees of freedom), nor poses "
                    "that are read in a wrong way: the standard deviations are wider for it. Take "
                    "ten poses or more",
                    answer.views.size(), answer.degrees_of_freedom));
  if (sights.problem().camera.covariance.size() == 0)
    add(answer.findings, code::lens_without_covariance,
        answer.num_corners > 0
            ? "the camera has no covariance: its lens is taken as exact, and the standard "
              "deviations do not include its errors"
            : "the poses count as independent: errors of a lens that all of them share are not "
              "part of the standard deviations");
}

}  // namespace

void report_minimum(const HandeyeSights& sights, const HandeyeMinimum& minimum,
                    HandeyeEstimate& answer) {
  std::vector<Pose> seen;
  for (const HandeyeSight& s : sights.problem().sights) seen.push_back(s.own[0].camera_from_target);
  const AxisSpread axes = axis_spread(seen);
  answer.axis_spread_rad = axes.spread_rad();
  answer.rotation_rad = axes.rms_rad[0];
  report_places(minimum, answer);
  report_views(sights, minimum, answer);
  check_determined(axes, sights.problem().scale, answer);
  if (!minimum.converged)
    add(answer.findings, code::not_converged, "the bundle stopped before it reached a minimum");
  add_warnings(sights, answer);
}

}  // namespace tagcal::internal
