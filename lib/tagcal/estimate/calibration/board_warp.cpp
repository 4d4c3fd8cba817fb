#include "tagcal/estimate/calibration/board_warp.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMaxRounds = 10;

void bend(ViewProblem& view, const FlatBoard& board, const Vector2d& bend_m) {
  const Vector3d normal = board.normal_in_world();
  for (Correspondence& c : view.correspondences)
    c.point += board.shape(board.world_from_board.inverse() * c.point).dot(bend_m) * normal;
}

std::optional<CalibrationFit> fit_largest_model(const CalibrationInput& input,
                                                const CalibrateOptions& options) {
  if (!is_auto(options)) return fit_model(input.models->named(options.model), input, options);
  auto perspective = fit_model(input.models->named("opencv5"), input, options);
  auto fisheye = fit_model(input.models->named("fisheye4"), input, options);
  if (!perspective || !fisheye) return perspective ? perspective : fisheye;
  const auto cost_per_corner = [](const CalibrationFit& fit) {
    return fit.summary.cost / std::max(1, fit.num_inliers());
  };
  const int fisheye_inliers = fisheye->num_inliers();
  const int perspective_inliers = perspective->num_inliers();
  if (policy::is_below(fisheye_inliers, policy::kComparableInliers, perspective_inliers))
    return perspective;
  if (policy::is_below(perspective_inliers, policy::kComparableInliers, fisheye_inliers))
    return fisheye;
  return cost_per_corner(*fisheye) < cost_per_corner(*perspective) ? fisheye : perspective;
}

}  // namespace

std::optional<BoardWarp> estimate_warp(const BundleInformation& information, double sigma) {
  const auto inverse = exact_inverse(information.halves[0] + information.halves[1]);
  if (!inverse) return std::nullopt;
  const VectorXd gradient = information.gradients[0] + information.gradients[1];
  const Vector2d step = -(*inverse * gradient).tail<2>();
  const Eigen::Matrix2d covariance = sigma * sigma * inverse->bottomRightCorner<2, 2>();
  BoardWarp warp;
  warp.bend_mm = 1e3 * step;
  warp.sigma_mm = 1e3 * covariance.diagonal().cwiseSqrt();
  const auto weight = exact_inverse(covariance);
  if (!weight) return std::nullopt;
  warp.chi_square = step.dot(*weight * step);
  return warp;
}

Vector2d remove_board_warp(CalibrationInput& input, const FlatBoard& board,
                           const CalibrateOptions& options) {
  std::optional<CalibrationFit> fit = fit_largest_model(input, options);
  if (!fit) return Vector2d::Zero();
  Vector2d total = Vector2d::Zero();
  for (int round = 0; round < kMaxRounds; ++round) {
    const auto information = bundle_information(fit->bundle, &board);
    const auto warp = information ? estimate_warp(*information, 1) : std::nullopt;
    if (!warp) return total;
    const Vector2d step = 1e-3 * warp->bend_mm;  // numeric: metres a millimetre
    for (ViewProblem& view : fit->bundle.views) bend(view, board, step);
    for (CalibrationView& view : input.views) bend(view.problem, board, step);
    total += step;
    if (!solve(fit->bundle, options.max_iterations).converged) return total;
    // numeric: convergence, far below the flatness of any board
    if (step.norm() < 1e-7 * board.half_size.norm()) return total;
  }
  return total;
}

}  // namespace tagcal::internal
