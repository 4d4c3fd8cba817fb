#include "tagcal/estimate/pose/reprojection.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tagcal/camera/batch.hpp"

namespace tagcal::internal {
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix2 whitening_of(const Matrix2& covariance_px2) {
  const Eigen::Matrix2d lower = Eigen::LLT<Eigen::Matrix2d>(covariance_px2).matrixL();
  const Eigen::Matrix2d inverse =
      lower.triangularView<Eigen::Lower>().solve(Eigen::Matrix2d::Identity());
  return inverse;
}

ViewArrays::ViewArrays(const ViewProblem& view) : whitening_(view.whitening) {
  points_.reserve(view.correspondences.size());
  pixels_.reserve(view.correspondences.size());
  for (const Correspondence& c : view.correspondences) {
    points_.push_back(c.point);
    pixels_.push_back(c.pixel);
  }
}

void ViewArrays::displace(const ViewShapes& shapes, const Eigen::Vector4d& by) {
  if (by.isZero()) return;
  for (std::size_t i = 0; i < shapes.of_points.size(); ++i) {
    const Eigen::Vector4d& shape = shapes.of_points[i];
    points_[i] +=
        shape.head<3>().dot(by.head<3>()) * shapes.normal + shape[3] * by[3] * shapes.across;
  }
}

void ViewArrays::move_rows(const Vector6d& velocity_in_target, double middle_row) {
  if (velocity_in_target.isZero(0)) return;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vector6d step = (pixels_[i].y() - middle_row) * velocity_in_target;
    points_[i] = small_rotation(step.head<3>()) * points_[i] + step.tail<3>();
  }
}

std::optional<Reprojection> reprojection(const ViewProblem& view, const Lens& lens,
                                         std::span<const FreeParameter> free,
                                         const Pose& camera_from_target) {
  const ViewArrays arrays(view);
  const ViewPoints seen = arrays.view();
  auto rows = projection_rows(lens, camera_from_target, seen.points, free);
  if (!rows) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(seen.size());
  Reprojection r{VectorXd(2 * n), std::move(rows->by_pose), std::move(rows->by_parameters)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    r.residuals.segment<2>(2 * i) = rows->pixels[k] - seen.pixels[k];
    if (seen.whitening.empty()) continue;
    const Matrix2& w = seen.whitening[k];
    r.residuals.segment<2>(2 * i) = (w * r.residuals.segment<2>(2 * i)).eval();
    r.by_pose.middleRows<2>(2 * i) = (w * r.by_pose.middleRows<2>(2 * i)).eval();
    r.by_parameters.middleRows<2>(2 * i) = (w * r.by_parameters.middleRows<2>(2 * i)).eval();
  }
  return r;
}

std::vector<double> whitened_squares(const ViewProblem& view, const Lens& lens,
                                     const Pose& camera_from_target) {
  std::vector<double> squares;
  squares.reserve(view.correspondences.size());
  for (const Vector2d& r : residuals_px(view.correspondences, lens, camera_from_target)) {
    const double square = view.whitening.empty()
                              ? r.squaredNorm()
                              : (view.whitening[squares.size()] * r).squaredNorm();
    squares.push_back(std::isfinite(square) ? square : std::numeric_limits<double>::infinity());
  }
  return squares;
}

ViewProblem chosen(const ViewProblem& view, std::span<const std::uint8_t> takes_part) {
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(takes_part.first(view.correspondences.size()),
                            [](std::uint8_t takes) { return takes != 0; }));
  if (count == view.correspondences.size()) return view;  // shares all of its memory
  ViewProblem some;
  some.correspondences.reserve(count);
  if (!view.whitening.empty()) some.whitening.reserve(count);
  for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
    if (!takes_part[i]) continue;
    some.correspondences.push_back(view.correspondences[i]);
    if (!view.whitening.empty()) some.whitening.push_back(view.whitening[i]);
  }
  return some;
}

ViewProblem inlier_view(std::span<const Correspondence> correspondences,
                        std::span<const Matrix2> covariance_px2,
                        std::span<const std::size_t> outliers, double sigma_px) {
  ViewProblem view;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    if (std::ranges::binary_search(outliers, i)) continue;
    view.correspondences.push_back(correspondences[i]);
    const Matrix2 whitening =
        covariance_px2.empty() ? Matrix2::Identity() : whitening_of(covariance_px2[i]);
    view.whitening.push_back(whitening / sigma_px);
  }
  return view;
}

std::vector<Vector2d> residuals_px(std::span<const Correspondence> correspondences,
                                   const Lens& lens, const Pose& camera_from_target) {
  std::vector<Vector3d> points;
  points.reserve(correspondences.size());
  for (const Correspondence& c : correspondences) points.push_back(c.point);
  std::vector<Vector2d> residuals(points.size());
  std::vector<std::uint8_t> valid(points.size());
  project(lens, camera_from_target, points, residuals, valid);
  for (std::size_t i = 0; i < residuals.size(); ++i) residuals[i] -= correspondences[i].pixel;
  return residuals;
}

}  // namespace tagcal::internal
