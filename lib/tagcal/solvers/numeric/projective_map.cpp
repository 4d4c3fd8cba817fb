#include "tagcal/solvers/numeric/projective_map.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cassert>
#include <cmath>
#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Linear map that turns the mean direction into the z axis and scales x and y so that the rays
// spread over about one unit: Hartley's normalisation for directions.
Matrix3d normalising_map(std::span<const Vector3d> rays) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& ray : rays) mean += ray.normalized();
  if (mean.norm() < 1e-6) return Matrix3d::Identity();
  const Matrix3d turn = rotation_between(mean, Vector3d::UnitZ()).toRotationMatrix();
  double square = 0;
  for (const Vector3d& ray : rays) square += (turn * ray.normalized()).head<2>().squaredNorm();
  const double stretch = std::sqrt(2 * static_cast<double>(rays.size()) / square);
  if (!std::isfinite(stretch)) return turn;
  return Vector3d(stretch, stretch, 1).asDiagonal() * turn;
}

// Two directions that span the plane perpendicular to v.
Eigen::Matrix<double, 3, 2> across(const Vector3d& v) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = v.unitOrthogonal();
  basis.col(1) = v.normalized().cross(basis.col(0));
  return basis;
}

// Returns M (3 x columns of x) with ray_i ~ M x_i: the null vector of the rows b kron x_i, with b
// perpendicular to ray_i. No value if the null space has more than one dimension.
std::optional<MatrixXd> direct_linear_transformation(const MatrixXd& x,
                                                     std::span<const Vector3d> rays) {
  const Eigen::Index n = x.cols(), d = x.rows();
  MatrixXd rows(std::max<Eigen::Index>(2 * n, 3 * d), 3 * d);
  rows.setZero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto basis = across(rays[static_cast<std::size_t>(i)]);
    for (Eigen::Index k = 0; k < 2; ++k)
      for (Eigen::Index r = 0; r < 3; ++r)
        rows.row(2 * i + k).segment(r * d, d) = basis(r, k) * x.col(i).transpose();
  }
  const MatrixXd triangle =
      MatrixXd(rows.householderQr().matrixQR().topRows(3 * d)).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<MatrixXd> svd(triangle, Eigen::ComputeFullV);
  const VectorXd& singular = svd.singularValues();
  if (!(singular(3 * d - 2) > 1e-10 * singular(0))) return std::nullopt;
  const VectorXd null = svd.matrixV().col(3 * d - 1);
  return MatrixXd(Eigen::Map<const MatrixXd>(null.data(), d, 3).transpose());
}

std::vector<Vector3d> mapped(const Matrix3d& map, std::span<const Vector3d> rays) {
  std::vector<Vector3d> result;
  for (const Vector3d& ray : rays) result.push_back((map * ray).normalized());
  return result;
}

}  // namespace

std::optional<MatrixXd> projective_map(const MatrixXd& x, std::span<const Vector3d> rays) {
  const Eigen::Index d = x.rows(), n = x.cols();
  assert(n == static_cast<Eigen::Index>(rays.size()));
  if (2 * n < 3 * d - 1) return std::nullopt;
  const VectorXd centre = x.topRows(d - 1).rowwise().mean();
  const double square = (x.topRows(d - 1).colwise() - centre).squaredNorm();
  const double scale = std::sqrt(static_cast<double>((d - 1) * n) / square);
  if (!std::isfinite(scale)) return std::nullopt;
  MatrixXd normalise = MatrixXd::Identity(d, d);
  normalise.topLeftCorner(d - 1, d - 1) *= scale;
  normalise.topRightCorner(d - 1, 1) = -scale * centre;
  const Matrix3d map = normalising_map(rays);
  const auto m = direct_linear_transformation(normalise * x, mapped(map, rays));
  if (!m) return std::nullopt;
  const MatrixXd result = map.inverse() * *m * normalise;
  double front = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    front += (result * x.col(i)).normalized().dot(rays[static_cast<std::size_t>(i)].normalized());
  return MatrixXd(result / (front < 0 ? -result.norm() : result.norm()));
}

}  // namespace tagcal::internal
