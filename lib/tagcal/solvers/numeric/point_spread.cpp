#include "tagcal/solvers/numeric/point_spread.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Ascending variances along the axes, the rows of `plane_from_target` in the opposite order.
Vector3d principal_variances(const Matrix3d& scatter, Matrix3d& plane_from_target) {
  if (scatter(2, 2) == 0) {  // all points at one z, as on most targets: the axes stay
    const double half_trace = (scatter(0, 0) + scatter(1, 1)) / 2;
    const double half_gap = std::hypot((scatter(0, 0) - scatter(1, 1)) / 2, scatter(0, 1));
    return {0, half_trace - half_gap, half_trace + half_gap};
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter);
  plane_from_target = eigen.eigenvectors().rowwise().reverse().transpose();
  if (plane_from_target.determinant() < 0) plane_from_target.row(2) *= -1;
  return eigen.eigenvalues();
}

}  // namespace

Pose PointSpread::plane_from_target_pose() const {
  return {Eigen::Quaterniond(plane_from_target), -(plane_from_target * centre)};
}

bool PointSpread::is_wide() const {
  return width > 1e-6 + 8 * std::numeric_limits<double>::epsilon() * centre.norm() / size;
}

PointSpread spread_of(std::span<const Vector3d> points) {
  PointSpread spread;
  if (points.empty()) return spread;
  const auto n = static_cast<double>(points.size());
  spread.reference = points.front();
  // Scalars stay in registers.
  const double x0 = spread.reference.x(), y0 = spread.reference.y(), z0 = spread.reference.z();
  double sx = 0, sy = 0, sz = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const Vector3d& p : points) {
    const double x = p.x() - x0, y = p.y() - y0, z = p.z() - z0;
    sx += x, sy += y, sz += z;
    xx += x * x, xy += x * y, xz += x * z;
    yy += y * y, yz += y * z, zz += z * z;
  }
  Matrix3d squares;
  squares << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  spread.from_reference = Vector3d(sx, sy, sz) / n;
  spread.centre = spread.reference + spread.from_reference;
  Matrix3d scatter = squares / n - spread.from_reference * spread.from_reference.transpose();
  // Compares the size with the rounding of the coordinates of equal points.
  const double square = scatter.trace();
  if (!(square > 1e-24 * spread.centre.squaredNorm()) || !std::isfinite(square)) return spread;
  scatter /= square;  // removes the unit of length
  const Vector3d variance = principal_variances(scatter, spread.plane_from_target);
  const Vector3d extent = variance.cwiseMax(0.0).cwiseSqrt();  // thickness, width, length
  spread.size = std::sqrt(square) * extent(2);
  spread.width = extent(1) / extent(2);
  spread.thickness = extent(0) / extent(2);
  if (spread.width < 1e-3)
    spread.shape = PointShape::line;
  else
    spread.shape = spread.thickness < 0.05 ? PointShape::plane : PointShape::space;
  return spread;
}

}  // namespace tagcal::internal
