#include "tagcal/uncertainty/uncertain_camera.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/uncertainty/rays/seen_ray.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A pixel, its Jacobian by the point, and its covariance through the lens.
struct Linear {
  Vector2d pixel;
  PointJacobian by_point;
  Matrix2 by_lens_px2 = Matrix2::Zero();
};

std::span<const FreeParameter> free_of(const UncertainCamera& known) {
  known.check_covariance();
  return known.is_exact() ? std::span<const FreeParameter>() : known.model->free();
}

std::optional<Linear> linearised(const UncertainCamera& known, const Vector3d& x) {
  const std::array<Vector3d, 1> points = {x};
  const auto rows = projection_rows(known.camera.lens, Pose(), points, free_of(known));
  if (!rows) return std::nullopt;
  // The derivatives by the translation are those by the point.
  Linear linear{rows->pixels[0], rows->by_pose.rightCols<3>(), Matrix2::Zero()};
  if (rows->by_parameters.cols() > 0)
    linear.by_lens_px2 = rows->by_parameters * known.covariance * rows->by_parameters.transpose();
  return linear;
}

// Matrix from the free parameters of one model to those of another.
Eigen::MatrixXd parameters_from(const Model& from, const Model& to) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(to.num_free(), from.num_free());
  for (int i = 0; i < to.num_free(); ++i) {
    const auto& target = to.free()[static_cast<std::size_t>(i)].lens_parameters;
    for (int j = 0; j < from.num_free(); ++j)
      for (const int k : from.free()[static_cast<std::size_t>(j)].lens_parameters)
        if (std::ranges::find(target, k) != target.end())
          result(i, j) += 1.0 / static_cast<double>(target.size());
  }
  return result;
}

}  // namespace

void UncertainCamera::check_covariance() const {
  const Eigen::Index k = num_free();
  if (covariance.size() == 0 || (covariance.rows() == k && covariance.cols() == k)) return;
  throw Error(fmt::format("the covariance of the lens must be {0} x {0} with {1}, got {2} x {3}", k,
                          model ? "model " + std::string(model->name()) : "no model",
                          covariance.rows(), covariance.cols()));
}

MatrixX covariance_by(const Model& model, const UncertainCamera& known) {
  const Eigen::MatrixXd by_free = parameters_from(*known.model, model);
  return by_free * known.covariance * by_free.transpose();
}

std::vector<double> lens_sigmas(const UncertainCamera& known) {
  std::vector<double> sigmas(parameters(known.camera.lens).size(), 0.0);
  for (std::size_t i = 0; i < known.model->free().size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    for (const int k : known.model->free()[i].lens_parameters)
      sigmas[static_cast<std::size_t>(k)] = std::sqrt(std::max(known.covariance(at, at), 0.0));
  }
  return sigmas;
}

std::string covariance_defect(const MatrixX& matrix) {
  constexpr double kRounding = 1e-5;       // numeric: files have six digits
  constexpr double kMostVariance = 1e100;  // numeric: products of a few are finite
  const Eigen::Index n = matrix.rows();
  const double largest = matrix.diagonal().maxCoeff();
  // Parameters have different units. A variance of 0 may have been computed with the rounding of
  // the largest one.
  Eigen::VectorXd unit(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double variance = matrix(i, i);
    unit(i) = std::sqrt(std::max(variance, kRounding * kRounding * largest));
    if (!(variance >= -kRounding * unit(i) * unit(i) && variance <= kMostVariance))
      return fmt::format("must have variances from 0 to {}, got {}", kMostVariance, variance);
    if (unit(i) == 0) unit(i) = 1;  // no variance at all
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (!(std::abs(matrix(i, j) - matrix(j, i)) <= kRounding * unit(i) * unit(j)))
        return fmt::format("must be symmetric, got {} and {}", matrix(j, i), matrix(i, j));
  const Eigen::VectorXd scale = unit.cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> llt(scaled + kRounding * Eigen::MatrixXd::Identity(n, n));
  return llt.info() == Eigen::Success ? "" : "must be positive semi-definite";
}

std::optional<UncertainPixel> project(const UncertainCamera& known,
                                      const UncertainPoint& in_camera) {
  const std::optional<Linear> linear = linearised(known, in_camera.x);
  if (!linear) return std::nullopt;
  return UncertainPixel{
      linear->pixel,
      linear->by_lens_px2 + linear->by_point * in_camera.covariance * linear->by_point.transpose()};
}

std::optional<UncertainPoint> direction(const UncertainCamera& known, const UncertainPixel& pixel) {
  const auto ray = seen_ray(known.camera.lens, pixel.pixel, free_of(known));
  if (!ray) return std::nullopt;
  Matrix2 sum = pixel.covariance_px2;
  if (const RowMajorX& by_lens = ray->pixel_by_parameters; by_lens.cols() > 0)
    sum += by_lens * known.covariance * by_lens.transpose();
  return UncertainPoint{ray->direction, ray->by_pixel * sum * ray->by_pixel.transpose()};
}

std::optional<UncertainPoint> point_at_depth(const UncertainCamera& known,
                                             const UncertainPixel& pixel, double depth_m,
                                             double sigma_depth_m) {
  const std::optional<UncertainPoint> ray = direction(known, pixel);
  if (!ray || !(ray->x.z() > 0) || !(depth_m > 0)) return std::nullopt;
  const Vector3d per_depth = ray->x / ray->x.z();
  Matrix3d by_direction = depth_m / ray->x.z() * Matrix3d::Identity();
  by_direction.col(2) -= depth_m / ray->x.z() * per_depth;
  return UncertainPoint{depth_m * per_depth,
                        by_direction * ray->covariance * by_direction.transpose() +
                            sigma_depth_m * sigma_depth_m * per_depth * per_depth.transpose()};
}

std::optional<UncertainPoint> point_on_plane(const UncertainCamera& known,
                                             const UncertainPixel& pixel,
                                             const Pose& camera_from_plane) {
  const std::optional<UncertainPoint> ray = direction(known, pixel);
  if (!ray) return std::nullopt;
  const Pose plane_from_camera = camera_from_plane.inverse();
  const Matrix3d turn = plane_from_camera.rotation_matrix();
  const Vector3d d = turn * ray->x, centre = plane_from_camera.translation();
  const double distance = -centre.z() / d.z();
  if (!std::isfinite(distance) || !(distance > 0)) return std::nullopt;
  Matrix3d by_direction = distance * Matrix3d::Identity();
  by_direction.col(2) -= distance / d.z() * d;
  by_direction = by_direction * turn;
  UncertainPoint point{centre + distance * d,
                       by_direction * ray->covariance * by_direction.transpose()};
  point.x.z() = 0;
  return point;
}

}  // namespace tagcal
