#include "tagcal/estimate/reprojection.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <optional>

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename L>
bool evaluate(const L& lens, const ViewProblem& view, std::span<const FreeParameter> free,
              const std::pair<Pose, Matrix3d>& pose_and_jacobian, double length,
              ReprojectionOutput& output) {
  const auto& [camera_from_target, left] = pose_and_jacobian;
  const Matrix3d rotation = camera_from_target.rotation_matrix();
  PointJacobian by_point;
  typename L::ParameterJacobian by_parameters;
  for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
    const Correspondence& c = view.correspondences[i];
    const Vector3d turned = rotation * c.point;
    const std::optional<Vector2d> pixel = lens.project(
        turned + camera_from_target.translation(), output.by_step ? &by_point : nullptr,
        output.by_parameters ? &by_parameters : nullptr);
    if (!pixel) return false;
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix2d whitening = view.whitening.empty()
                                          ? Eigen::Matrix2d(Eigen::Matrix2d::Identity())
                                          : Eigen::Matrix2d(view.whitening[i]);
    output.residuals.segment<2>(row) = whitening * (*pixel - c.pixel);
    if (output.by_step) {
      const Eigen::Matrix<double, 2, 3> j = whitening * by_point;
      output.by_step->block<2, 3>(row, 0) = -j * cross_matrix(turned) * left;
      output.by_step->block<2, 3>(row, 3) = length * j;
    }
    if (!output.by_parameters) continue;
    for (std::size_t k = 0; k < free.size(); ++k) {
      Vector2d sum = Vector2d::Zero();
      for (const int index : free[k].lens_parameters) sum += by_parameters.col(index);
      output.by_parameters->block<2, 1>(row, static_cast<Eigen::Index>(k)) = whitening * sum;
    }
  }
  return true;
}

}  // namespace

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

Pose PoseStep::at(const Vector6d& step) const {
  Vector6d scaled = step;
  scaled.tail<3>() *= length;
  return retract(reference, scaled);
}

bool reprojection(const ViewProblem& view, const Lens& lens, std::span<const FreeParameter> free,
                  const PoseStep& pose, const Vector6d& step, ReprojectionOutput& output) {
  const std::pair<Pose, Matrix3d> at(pose.at(step), left_jacobian(step.head<3>()));
  return std::visit([&](const auto& l) { return evaluate(l, view, free, at, pose.length, output); },
                    lens);
}

double whitened_square(const ViewProblem& view, std::size_t i, const Vector2d& residual) {
  const double square = view.whitening.empty() ? residual.squaredNorm()
                                               : (view.whitening[i] * residual).squaredNorm();
  return std::isfinite(square) ? square : std::numeric_limits<double>::infinity();
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

}  // namespace tagcal
