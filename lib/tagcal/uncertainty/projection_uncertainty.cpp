#include "tagcal/uncertainty/projection_uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/projection_rows.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Jacobians {
  MatrixXd by_pose;  // 3 columns at infinity, else 6
  MatrixXd by_parameters;
};

// Jacobians of the pixels that have a ray; `index` are the numbers of these pixels.
Jacobians jacobians(const UncertainCamera& known, std::span<const Vector2d> pixels,
                    double distance_m, std::vector<std::size_t>& index) {
  std::vector<Vector3d> points;
  index.clear();
  const bool far = !std::isfinite(distance_m);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::optional<Ray> ray = ray_in_camera(known.camera.lens, pixels[i]);
    if (!ray || !in_domain(known.camera.lens, ray->direction)) continue;
    points.push_back((far ? 1.0 : distance_m) * ray->direction);
    index.push_back(i);
  }
  auto j = projection_rows(known.camera.lens, Pose(), points, known.model->free());
  if (!j || index.empty()) {
    index.clear();
    return {MatrixXd(0, far ? 3 : 6), MatrixXd(0, known.model->num_free())};
  }
  if (far) return {MatrixXd(j->by_pose.leftCols<3>()), MatrixXd(j->by_parameters)};
  j->by_pose.rightCols<3>() *= distance_m;  // scales the columns like those of the rotation
  return {MatrixXd(j->by_pose), MatrixXd(j->by_parameters)};
}

// Change of the common pose by each parameter, which explains most of the projection's change
// (least squares).
MatrixXd pose_by_parameters(const Jacobians& j) {
  return j.by_pose.colPivHouseholderQr().solve(j.by_parameters);
}

double mean_variance(const MatrixXd& rows, const MatrixXd& covariance) {
  const double sum = (rows * covariance).cwiseProduct(rows).sum();
  return std::max(0.0, sum) / static_cast<double>(rows.rows());
}

constexpr std::size_t kDirectionsShown = 3;

// A sentence that names the correlation of a weak parameter, its consequence, and a remedy.
const char* correlation_sentence(ParameterRole parameter) {
  switch (parameter) {
    case ParameterRole::focal_length:
      return "the views cannot tell focal length from distance, so the projection is uncertain: "
             "take 3 views with the board tilted by 30 degrees or more";
    case ParameterRole::radial:
    case ParameterRole::shape:
      return "the views cannot tell the distortion coefficients apart, so the projection is "
             "uncertain: take views with the board in the corners of the image";
    default:
      return "the views cannot tell the principal point from tilts of the board, so the projection "
             "is uncertain: tilt the board to all sides, and turn it about its normal between "
             "views";
  }
}

}  // namespace

MatrixX aligned_jacobian(const UncertainCamera& known, std::span<const Vector2d> samples,
                         double distance_m) {
  std::vector<std::size_t> index;
  const Jacobians j = jacobians(known, samples, distance_m, index);
  if (index.empty()) return j.by_parameters;
  return j.by_parameters - j.by_pose * pose_by_parameters(j);
}

ProjectionUncertainty projection_uncertainty(const UncertainCamera& known, const ImageGrid& grid,
                                             std::span<const Vector2d> samples, double distance_m) {
  ProjectionUncertainty result{distance_m, grid, {}, kInfinitelyFar, kInfinitelyFar};
  result.sigma_px =
      MatrixXd::Constant(grid.rows, grid.columns, std::numeric_limits<double>::quiet_NaN());
  std::vector<std::size_t> index;
  const Jacobians of_samples = jacobians(known, samples, distance_m, index);
  if (index.size() < 3) return result;
  const MatrixXd pose_change = pose_by_parameters(of_samples);
  const MatrixXd aligned = of_samples.by_parameters - of_samples.by_pose * pose_change;
  result.region_px = std::sqrt(mean_variance(aligned, known.covariance));
  result.region_max_px = 0;
  for (Eigen::Index row = 0; row < aligned.rows(); row += 2)
    result.region_max_px =
        std::max(result.region_max_px,
                 std::sqrt(mean_variance(aligned.middleRows<2>(row), known.covariance)));
  const std::vector<Vector2d> nodes = grid.pixels();
  const Jacobians of_nodes = jacobians(known, nodes, distance_m, index);
  const MatrixXd rows = of_nodes.by_parameters - of_nodes.by_pose * pose_change;
  for (std::size_t i = 0; i < index.size(); ++i) {
    const auto node = static_cast<Eigen::Index>(index[i]);
    result.sigma_px(node / grid.columns, node % grid.columns) = std::sqrt(
        mean_variance(rows.middleRows<2>(2 * static_cast<Eigen::Index>(i)), known.covariance));
  }
  return result;
}

std::vector<WeakDirection> weak_directions(const UncertainCamera& known,
                                           std::span<const Vector2d> samples) {
  const MatrixXd projection = aligned_jacobian(known, samples, kInfinitelyFar);
  std::vector<WeakDirection> directions;
  if (projection.rows() == 0 || !known.covariance.allFinite()) return directions;
  // A root of the covariance, which held parameters make singular.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> of_parameters(known.covariance);
  const MatrixXd lower = of_parameters.eigenvectors() *
                         of_parameters.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const MatrixXd effect = projection * lower / std::sqrt(static_cast<double>(projection.rows()));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(effect.transpose() * effect);
  const Index k = spectrum.eigenvalues().size();
  for (Index i = k - 1; i >= 0 && directions.size() < kDirectionsShown; --i) {
    const VectorXd direction = lower * spectrum.eigenvectors().col(i);
    Index strongest = 0;
    projection.colwise().norm().transpose().cwiseProduct(direction.cwiseAbs()).maxCoeff(&strongest);
    const auto parameter = static_cast<std::size_t>(strongest);
    const double sigma = std::sqrt(std::max(0.0, spectrum.eigenvalues()[i]));
    directions.push_back({std::string(known.model->free()[parameter].name), sigma,
                          correlation_sentence(known.model->parameter(parameter).role)});
  }
  return directions;
}

}  // namespace tagcal
