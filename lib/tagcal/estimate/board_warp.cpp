#include "tagcal/estimate/board_warp.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/uncertainty.hpp"

namespace tagcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMaxRounds = 10;

// One view's part of the normal equations of (parameters, bend), its pose eliminated.
struct Part {
  MatrixXd information;
  VectorXd gradient;
};

std::optional<Part> part_of(const Bundle& bundle, std::size_t v, const FlatBoard& board) {
  const ViewProblem& view = bundle.views[v];
  const Pose& pose = bundle.camera_from_target[v];
  const auto j = view_jacobians(view, bundle.lens(), bundle.model->free(), pose);
  if (!j) return std::nullopt;
  const Index k = bundle.model->num_free();
  MatrixXd by_both(j->by_pose.rows(), k + 2);
  by_both.leftCols(k) = j->by_parameters;
  const Vector3d normal = pose.rotation() * board.normal_in_world();
  for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
    const auto row = static_cast<Index>(2 * i);
    by_both.block<2, 2>(row, k) = j->by_pose.block<2, 3>(row, 3) * normal *
                                  board.shape(view.correspondences[i].point).transpose();
  }
  const auto inverse = exact_inverse(j->by_pose.transpose() * j->by_pose);
  if (!inverse) return std::nullopt;
  const MatrixXd rest = by_both - j->by_pose * (*inverse * (j->by_pose.transpose() * by_both));
  return Part{rest.transpose() * rest, rest.transpose() * j->residuals};
}

void bend(ViewProblem& view, const FlatBoard& board, const Vector2d& bend_m) {
  const Vector3d normal = board.normal_in_world();
  for (Correspondence& c : view.correspondences)
    c.point += board.shape(c.point).dot(bend_m) * normal;
}

std::optional<CalibrationFit> largest_fit(const CalibrationInput& input,
                                          const CalibrateOptions& options) {
  if (!options.model.empty() && options.model != "auto")
    return fit_model(Model::named(options.model), input, options);
  auto perspective = fit_model(Model::named("opencv5"), input, options);
  auto fisheye = fit_model(Model::named("fisheye4"), input, options);
  if (!perspective || !fisheye) return perspective ? perspective : fisheye;
  const auto per_corner = [](const CalibrationFit& fit) {
    return fit.summary.cost / std::max(1, fit.num_inliers());
  };
  if (10 * fisheye->num_inliers() < 9 * perspective->num_inliers()) return perspective;
  if (10 * perspective->num_inliers() < 9 * fisheye->num_inliers()) return fisheye;
  return per_corner(*fisheye) < per_corner(*perspective) ? fisheye : perspective;
}

}  // namespace

Vector2d FlatBoard::shape(const Vector3d& x_in_world) const {
  const Vector3d x_in_board = world_from_board.inverse() * x_in_world;
  const Vector2d unit = (x_in_board.head<2>() - centre).cwiseQuotient(half_size);
  return Vector2d::Ones() - unit.cwiseAbs2();
}

Vector3d FlatBoard::normal_in_world() const {
  return world_from_board.rotation() * Vector3d::UnitZ();
}

std::optional<FlatBoard> flat_board(const Dataset& dataset) {
  if (dataset.boards.size() != 1) return std::nullopt;
  const auto points = target_points(dataset.boards[0].board);
  if (points.empty()) return std::nullopt;
  Vector3d low = points[0].position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  const Vector3d size = high - low;
  if (!(size.x() > 0 && size.y() > 0) || size.z() > 1e-6 * size.x()) return std::nullopt;
  return FlatBoard{dataset.boards[0].world_from_board, 0.5 * (low + high).head<2>(),
                   0.5 * size.head<2>()};
}

std::optional<BoardWarp> estimate_warp(const Bundle& solved, const FlatBoard& board, double sigma) {
  const Index n = solved.model->num_free() + 2;
  MatrixXd information = MatrixXd::Zero(n, n);
  VectorXd gradient = VectorXd::Zero(n);
  for (std::size_t v = 0; v < solved.views.size(); ++v) {
    const std::optional<Part> part = part_of(solved, v, board);
    if (!part) return std::nullopt;
    information += part->information;
    gradient += part->gradient;
  }
  const auto inverse = exact_inverse(information);
  if (!inverse) return std::nullopt;
  const Vector2d step = -(*inverse * gradient).tail<2>();
  const Eigen::Matrix2d covariance = sigma * sigma * inverse->bottomRightCorner<2, 2>();
  BoardWarp warp;
  warp.bend_mm = 1e3 * step;
  warp.sigma_mm = 1e3 * covariance.diagonal().cwiseSqrt();
  const auto weight = exact_inverse(covariance);
  if (!weight) return std::nullopt;
  warp.chi_square = step.dot(*weight * step);
  warp.parameter_covariance = sigma * sigma * inverse->topLeftCorner(n - 2, n - 2);
  return warp;
}

Vector2d unbend(CalibrationInput& input, const FlatBoard& board, const CalibrateOptions& options) {
  std::optional<CalibrationFit> fit = largest_fit(input, options);
  if (!fit) return Vector2d::Zero();
  Vector2d total = Vector2d::Zero();
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::optional<BoardWarp> warp = estimate_warp(fit->bundle, board, 1);
    if (!warp) return total;
    const Vector2d step = 1e-3 * warp->bend_mm;
    for (ViewProblem& view : fit->bundle.views) bend(view, board, step);
    for (CalibrationView& view : input.views) bend(view.problem, board, step);
    total += step;
    if (!solve(fit->bundle, options.max_iterations).converged) return total;
    if (step.norm() < 1e-7 * board.half_size.norm()) return total;
  }
  return total;
}

}  // namespace tagcal
