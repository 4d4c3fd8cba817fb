#include "tagcal/estimate/projection_uncertainty.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

struct Jacobians {
  MatrixXd by_pose;  // 3 columns at infinity, else 6
  MatrixXd by_parameters;
};

// Jacobians of the pixels that have a ray; `index` are the numbers of these pixels.
Jacobians jacobians(const UncertainLens& lens, std::span<const Vector2d> pixels, double distance_m,
                    std::vector<std::size_t>& index) {
  ViewProblem points;
  index.clear();
  const bool far = !std::isfinite(distance_m);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::optional<Ray> ray = ray_in_camera(lens.lens, pixels[i]);
    if (!ray || !in_domain(lens.lens, ray->direction)) continue;
    points.correspondences.push_back({(far ? 1.0 : distance_m) * ray->direction, pixels[i]});
    index.push_back(i);
  }
  auto r = reprojection(points, lens.lens, lens.model->free(), Pose());
  if (!r || index.empty()) {
    index.clear();
    return {MatrixXd(0, far ? 3 : 6), MatrixXd(0, lens.model->num_free())};
  }
  if (far) return {MatrixXd(r->by_pose.leftCols<3>()), MatrixXd(r->by_parameters)};
  r->by_pose.rightCols<3>() *= distance_m;  // scales the columns like those of the rotation
  return {MatrixXd(r->by_pose), MatrixXd(r->by_parameters)};
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

// Matrix from the free parameters of one model to those of another.
MatrixXd parameters_from(const Model& from, const Model& to) {
  MatrixXd result = MatrixXd::Zero(to.num_free(), from.num_free());
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

MatrixX covariance_by(const Model& model, const UncertainLens& lens) {
  const MatrixXd by_free = parameters_from(*lens.model, model);
  return by_free * lens.covariance * by_free.transpose();
}

std::vector<double> lens_sigmas(const UncertainLens& lens) {
  std::vector<double> sigmas(parameters(lens.lens).size(), 0.0);
  for (std::size_t i = 0; i < lens.model->free().size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    for (const int k : lens.model->free()[i].lens_parameters)
      sigmas[static_cast<std::size_t>(k)] = std::sqrt(std::max(lens.covariance(at, at), 0.0));
  }
  return sigmas;
}

MatrixX aligned_jacobian(const UncertainLens& lens, std::span<const Vector2d> samples,
                         double distance_m) {
  std::vector<std::size_t> index;
  const Jacobians j = jacobians(lens, samples, distance_m, index);
  if (index.empty()) return j.by_parameters;
  return j.by_parameters - j.by_pose * pose_by_parameters(j);
}

ProjectionUncertainty projection_uncertainty(const UncertainLens& lens, const ImageGrid& grid,
                                             std::span<const Vector2d> samples, double distance_m) {
  ProjectionUncertainty result{distance_m, grid, {}, kInfinitelyFar, kInfinitelyFar};
  result.sigma_px =
      MatrixXd::Constant(grid.rows, grid.columns, std::numeric_limits<double>::quiet_NaN());
  std::vector<std::size_t> index;
  const Jacobians of_samples = jacobians(lens, samples, distance_m, index);
  if (index.size() < 3) return result;
  const MatrixXd pose_change = pose_by_parameters(of_samples);
  const MatrixXd aligned = of_samples.by_parameters - of_samples.by_pose * pose_change;
  result.region_px = std::sqrt(mean_variance(aligned, lens.covariance));
  result.region_max_px = 0;
  for (Eigen::Index row = 0; row < aligned.rows(); row += 2)
    result.region_max_px =
        std::max(result.region_max_px,
                 std::sqrt(mean_variance(aligned.middleRows<2>(row), lens.covariance)));
  const std::vector<Vector2d> nodes = grid.pixels();
  const Jacobians of_nodes = jacobians(lens, nodes, distance_m, index);
  const MatrixXd rows = of_nodes.by_parameters - of_nodes.by_pose * pose_change;
  for (std::size_t i = 0; i < index.size(); ++i) {
    const auto node = static_cast<Eigen::Index>(index[i]);
    result.sigma_px(node / grid.columns, node % grid.columns) = std::sqrt(
        mean_variance(rows.middleRows<2>(2 * static_cast<Eigen::Index>(i)), lens.covariance));
  }
  return result;
}

}  // namespace tagcal
