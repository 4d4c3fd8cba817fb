#include "tagcal/solvers/numeric/object_space.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

using Vector10d = Eigen::Matrix<double, 10, 1>;

// Sums of the products of (xx xy xz yy yz zz x y z 1) of a point (rows) and the upper triangle of
// Q = 1 - v v' (columns).
using Moments = Eigen::Matrix<double, 10, 6>;

constexpr double kOneRay = 1e-9;

// For a ray near z, the small elements of 1 - v v' are computed from small numbers, not as a
// difference of large ones, so that distant targets lose no digits.
Vector6d projector(const Vector3d& v) {
  const double xx = v.x() * v.x(), yy = v.y() * v.y(), zz = v.z() * v.z();
  Vector6d q;
  q << yy + zz, -v.x() * v.y(), -v.x() * v.z(), xx + zz, -v.y() * v.z(), xx + yy;
  return q;
}

Matrix3d symmetric(const Vector6d& upper) {
  Matrix3d m;
  m << upper(0), upper(1), upper(2), upper(1), upper(3), upper(4), upper(2), upper(4), upper(5);
  return m;
}

Matrix3d z_along_mean(std::span<const Vector3d> rays) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& v : rays) mean += v.stableNormalized();
  if (mean.norm() < 1e-3 * static_cast<double>(rays.size())) return Matrix3d::Identity();
  return rotation_between(mean, Vector3d::UnitZ()).toRotationMatrix();
}

struct Sums {
  Moments moments = Moments::Zero();
  Vector3d ray = Vector3d::Zero();        // v
  Matrix3d ray_point = Matrix3d::Zero();  // v x'
};

Sums sums_of(std::span<const Vector3d> points, std::span<const Vector3d> rays,
             const PointSpread& frame, const Matrix3d& rays_from_camera) {
  Sums sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d x = frame.in_plane(points[i]) / frame.size;
    const Vector3d v = rays_from_camera * rays[i].stableNormalized();
    Vector10d monomials;
    monomials << x.x() * x, x.y() * x.y(), x.y() * x.z(), x.z() * x.z(), x, 1;
    sums.moments.noalias() += monomials * projector(v).transpose();
    sums.ray += v;
    sums.ray_point.noalias() += v * x.transpose();
  }
  const double scale = 1 / static_cast<double>(points.size());
  sums.moments *= scale;
  sums.ray *= scale;
  sums.ray_point *= scale;
  return sums;
}

}  // namespace

Pose ObjectSpaceError::camera_from_target(const Quaterniond& rays_from_points) const {
  const Vector3d t = frame.size * (translation_map * columns_of(rays_from_points));
  const Matrix3d rotation =
      rays_from_camera.transpose() * rays_from_points.toRotationMatrix() * frame.plane_from_target;
  return {Quaterniond(rotation).normalized(),
          rays_from_camera.transpose() * t - rotation * frame.centre};
}

std::optional<ObjectSpaceError> object_space_error(std::span<const Vector3d> points,
                                                   std::span<const Vector3d> rays) {
  ObjectSpaceError e;
  e.frame = spread_of(points);
  if (!e.frame.is_wide()) return std::nullopt;
  e.rays_from_camera = z_along_mean(rays);
  const Sums sums = sums_of(points, rays, e.frame, e.rays_from_camera);
  if (!sums.moments.allFinite()) return std::nullopt;
  const Matrix3d q = symmetric(sums.moments.row(9));
  const Eigen::LLT<Matrix3d> factors(q);
  if (factors.info() != Eigen::Success || !(q.trace() > 0)) return std::nullopt;
  const double spread = factors.matrixLLT().diagonal().minCoeff();
  if (!(spread > kOneRay)) return std::nullopt;

  Matrix39 p;
  for (int k = 0; k < 3; ++k) p.middleCols<3>(3 * k) = symmetric(sums.moments.row(6 + k));
  e.translation_map = -factors.solve(p);
  constexpr int kMonomial[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l)
      e.omega.block<3, 3>(3 * k, 3 * l) = symmetric(sums.moments.row(kMonomial[k][l]));
  e.omega.noalias() += p.transpose() * e.translation_map;
  e.depth_map = e.translation_map.transpose() * sums.ray;
  e.depth_map += Eigen::Map<const Vector9>(sums.ray_point.data());
  return e;
}

Vector9 columns_of(const Quaterniond& rotation) {
  const Matrix3d m = rotation.toRotationMatrix();
  return Eigen::Map<const Vector9>(m.data());
}

RotationExpansion expansion(const Matrix9& omega, const Vector9& r) {
  const Vector9 g = omega * r;
  const Eigen::Map<const Matrix3d> rotation(r.data()), slope(g.data());
  const Matrix3d s = rotation.transpose() * slope;
  // The columns c_k of R change by R (w x e_k): J = [0 -c3 c2; c3 0 -c1; -c2 c1 0].
  const auto c1 = r.head<3>(), c2 = r.segment<3>(3), c3 = r.tail<3>();
  const auto o1 = omega.leftCols<3>(), o2 = omega.middleCols<3>(3), o3 = omega.rightCols<3>();
  Eigen::Matrix<double, 9, 3> m;
  m.col(0).noalias() = o2 * c3 - o3 * c2;
  m.col(1).noalias() = o3 * c1 - o1 * c3;
  m.col(2).noalias() = o1 * c2 - o2 * c1;
  RotationExpansion e;
  e.value = 0.5 * s.trace();
  e.gradient = {s(2, 1) - s(1, 2), s(0, 2) - s(2, 0), s(1, 0) - s(0, 1)};
  Matrix3d gauss_newton;
  gauss_newton.row(0).noalias() =
      c3.transpose() * m.middleRows<3>(3) - c2.transpose() * m.bottomRows<3>();
  gauss_newton.row(1).noalias() =
      c1.transpose() * m.bottomRows<3>() - c3.transpose() * m.topRows<3>();
  gauss_newton.row(2).noalias() =
      c2.transpose() * m.topRows<3>() - c1.transpose() * m.middleRows<3>(3);
  e.hessian = gauss_newton + 0.5 * (s + s.transpose());
  e.hessian.diagonal().array() -= s.trace();
  return e;
}

namespace {

constexpr int kMaxSteps = 40;
constexpr double kLongestStep = 1;   // rad
constexpr double kConverged = 1e-9;  // rad; the next step would be its square
constexpr double kFlat = 1e-3;       // of the trace: least curvature that a long step divides by
constexpr double kKick = 0.3;        // rad, off a saddle

// Returns q exp(w) to second order, as an exact rotation.
Quaterniond turned(const Quaterniond& q, const Vector3d& w) {
  return (q * Quaterniond(1, w.x() / 2, w.y() / 2, w.z() / 2)).normalized();
}

// No step unless the Hessian is positive definite.
std::optional<Vector3d> newton_step(const RotationExpansion& at) {
  SmallCholesky<3> cholesky;
  if (!cholesky.compute(at.hessian)) return std::nullopt;
  return -cholesky.solve(at.gradient);
}

// Descends along every axis of the Hessian, whatever the sign of its curvature, and so leaves
// saddles (Dauphin et al., NIPS 2014).
Vector3d downhill_step(const RotationExpansion& at) {
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(at.hessian);
  const Vector3d curvature =
      eigen.eigenvalues().cwiseAbs().cwiseMax(kFlat * eigen.eigenvalues().cwiseAbs().sum());
  const Matrix3d& axes = eigen.eigenvectors();
  Vector3d along = -(axes.transpose() * at.gradient).cwiseQuotient(curvature);
  if (eigen.eigenvalues()(0) < 0 && along.norm() < 1e-3 * kKick)
    along(0) = along(0) < 0 ? -kKick : kKick;
  return axes * along * std::min(1.0, kLongestStep / along.norm());
}

}  // namespace

std::optional<RotationMinimum> descend(const Matrix9& omega, const Quaterniond& start) {
  const double rounding = std::numeric_limits<double>::epsilon() * omega.trace();
  Quaterniond q = start;
  RotationExpansion at = expansion(omega, columns_of(q));
  double shorten = 1;
  for (int i = 0; i < kMaxSteps; ++i) {
    std::optional<Vector3d> step = newton_step(at);
    const bool newton = step && step->squaredNorm() < kLongestStep * kLongestStep;
    const Vector3d w = shorten * (newton ? *step : downhill_step(at));
    const Quaterniond next_q = turned(q, w);
    const RotationExpansion next = expansion(omega, columns_of(next_q));
    if (!(next.value <= at.value + rounding)) {
      shorten *= 0.35;
      continue;
    }
    q = next_q;
    at = next;
    if (newton && w.squaredNorm() < kConverged * kConverged) break;
    shorten = 1;
  }
  if (!newton_step(at)) return std::nullopt;
  return RotationMinimum{q, 2 * at.value};
}

}  // namespace tagcal::internal
