#include "tagcal/solvers/weak_perspective.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "tagcal/error.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

constexpr double kThin = 0.05;
constexpr double kFlat = 1e-7;  // thickness below which the answer of the plane is exact
constexpr double kSameRad = 1e-4;
constexpr double kConverged = 1e-18;  // of the error, for pixels of unit RMS
constexpr double kLongestStep = 1;

// Second moments of the points x (in their frame) and the pixels u (centred, of unit RMS). The
// error of u = A x is tr(A xx A') / 2 - tr(ux' A) + uu / 2.
struct Moments {
  Matrix3d xx = Matrix3d::Zero();
  Matrix23d ux = Matrix23d::Zero();
  double uu = 0;
};

struct Pixels {
  Vector2d mean = Vector2d::Zero();
  double size = 0;
};

Pixels centred(std::span<const Vector2d> pixels) {
  const auto n = static_cast<double>(pixels.size());
  Pixels spread;
  Vector2d sum = Vector2d::Zero();
  for (const Vector2d& p : pixels) sum += p - pixels[0];
  spread.mean = pixels[0] + sum / n;
  double square = 0;
  for (const Vector2d& p : pixels) square += (p - spread.mean).squaredNorm();
  spread.size = std::sqrt(square / n);
  return spread;
}

Moments moments_of(std::span<const Vector3d> points, std::span<const Vector2d> pixels,
                   const PointSpread& frame, const Pixels& spread) {
  Moments m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d x = frame.in_plane(points[i]) / frame.size;
    const Vector2d u = (pixels[i] - spread.mean) / spread.size;
    m.xx.noalias() += x * x.transpose();
    m.ux.noalias() += u * x.transpose();
    m.uu += u.squaredNorm();
  }
  const auto n = static_cast<double>(points.size());
  m.xx /= n;
  m.ux /= n;
  m.uu /= n;
  return m;
}

// A scaled rotation in the frames of points and pixels: u = scale (R x)_xy.
struct ScaledRotation {
  Quaterniond rotation = Quaterniond::Identity();
  double scale = 0;
};

Matrix23d affine_of(const ScaledRotation& a) {
  return a.scale * a.rotation.toRotationMatrix().topRows<2>();
}

double error_of(const Moments& m, const Matrix23d& a) {
  return 0.5 * (a * m.xx - 2 * m.ux).cwiseProduct(a).sum() + 0.5 * m.uu;
}

Quaterniond rotation_from_rows(const Vector3d& first, const Vector3d& second) {
  Matrix3d r;
  r.row(0) = first;
  r.row(1) = second;
  r.row(2) = first.cross(second);
  return Quaterniond(r).normalized();
}

// The two scaled rotations whose upper left block is the affine fit of the plane.
std::array<ScaledRotation, 2> plane_solutions(const Moments& m) {
  const Matrix2d a = m.ux.leftCols<2>() * m.xx.topLeftCorner<2, 2>().inverse();
  const Eigen::JacobiSVD<Matrix2d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double scale = svd.singularValues()(0), ratio = svd.singularValues()(1) / scale;
  const Vector2d tilt = std::sqrt((1 - ratio) * (1 + ratio)) * svd.matrixU().col(1);
  const Matrix2d block = a / scale;
  std::array<ScaledRotation, 2> solutions;
  for (const int k : {0, 1}) {
    const Vector2d third = k == 0 ? tilt : Vector2d(-tilt);
    const auto row = [&](int i) { return Vector3d(block(i, 0), block(i, 1), third(i)); };
    solutions[static_cast<std::size_t>(k)] = {rotation_from_rows(row(0), row(1)), scale};
  }
  return solutions;
}

// The scaled rotation nearest to the affine fit of points in space: rows (A A')^(-1/2) A, with the
// root of a 2 x 2 matrix S, (S + sqrt(|S|)) / sqrt(tr S + 2 sqrt(|S|)).
ScaledRotation space_start(const Moments& m) {
  const Matrix23d a = m.xx.ldlt().solve(m.ux.transpose()).transpose();
  const Matrix2d square = a * a.transpose();
  const double root = std::sqrt(std::max(0.0, square.determinant()));
  const Matrix2d stretch =
      (square + root * Matrix2d::Identity()) / std::sqrt(square.trace() + 2 * root);
  const Matrix23d rows = stretch.inverse() * a;
  return {rotation_from_rows(rows.row(0), rows.row(1)), 0.5 * stretch.trace()};
}

// Gradient and Hessian of the error at exp(w) R, scale exp(l), in (w, l).
struct Expansion {
  double cost = 0;
  Vector4d gradient;
  Matrix4d hessian;
  Matrix4d gauss_newton;

  // Newton's step if the Hessian is positive definite, otherwise a damped Gauss-Newton step.
  std::optional<DampedStep<Vector4d>> step(double damping) const {
    Eigen::LLT<Matrix4d> factors(hessian);
    if (damping > 0 || factors.info() != Eigen::Success) {
      Matrix4d damped = gauss_newton;
      damped.diagonal().array() += std::max(1e-3, damping) * damped.trace();
      factors.compute(damped);
    }
    Vector4d step = -factors.solve(gradient);
    if (!step.allFinite()) return std::nullopt;
    step *= std::min(1.0, kLongestStep / step.norm());
    return DampedStep<Vector4d>{step, -0.5 * step.dot(gradient)};
  }
};

// The scaled rotation of least error for points in space.
struct RotationProblem {
  using State = ScaledRotation;
  const Moments& m;

  std::optional<Expansion> at(const State& at) const;

  static State stepped(const State& at, const Vector4d& step) {
    return {(exp_rotation(step.head<3>()) * at.rotation).normalized(),
            at.scale * std::exp(step(3))};
  }
};

std::optional<Expansion> RotationProblem::at(const State& at) const {
  const Matrix3d r = at.rotation.toRotationMatrix();
  const Matrix23d a = at.scale * r.topRows<2>();
  const Matrix23d slope = a * m.xx - m.ux;
  // Derivatives of A by (w, l): the rows of w x R are (w2 r3 - w3 r2) and (w3 r1 - w1 r3).
  std::array<Matrix23d, 4> moves;
  for (Matrix23d& move : moves) move.setZero();
  moves[0].row(1) = -at.scale * r.row(2);
  moves[1].row(0) = at.scale * r.row(2);
  moves[2].row(0) = -a.row(1);
  moves[2].row(1) = a.row(0);
  moves[3] = a;

  Expansion e;
  e.cost = error_of(m, a);
  if (!std::isfinite(e.cost)) return std::nullopt;
  for (int i = 0; i < 4; ++i) {
    const Matrix23d& move = moves[static_cast<std::size_t>(i)];
    e.gradient(i) = move.cwiseProduct(slope).sum();
    const Matrix23d weighted = move * m.xx;
    for (int j = 0; j < 4; ++j)
      e.gauss_newton(i, j) = moves[static_cast<std::size_t>(j)].cwiseProduct(weighted).sum();
  }
  // Second order of exp: (w w' - |w|^2) R / 2 of the rotation, l w of both, l^2 / 2.
  Matrix3d twist = Matrix3d::Zero();
  twist.leftCols<2>() = at.scale * r * slope.transpose();
  e.hessian = e.gauss_newton;
  e.hessian.topLeftCorner<3, 3>() += 0.5 * (twist + twist.transpose());
  e.hessian.diagonal().head<3>().array() -= twist.trace();
  e.hessian.topRightCorner<3, 1>() += e.gradient.head<3>();
  e.hessian.bottomLeftCorner<1, 3>() += e.gradient.head<3>().transpose();
  e.hessian(3, 3) += e.gradient(3);
  return e;
}

ScaledRotation refined(const Moments& m, const ScaledRotation& start) {
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * m.uu;
  const auto best =
      minimise(RotationProblem{m}, start,
               {.damping = 0, .flat = 0, .least_decrease = kConverged, .rounding = rounding});
  return best ? best->state : start;
}

WeakPerspectivePose posed(const ScaledRotation& a, const PointSpread& frame, const Pixels& spread) {
  WeakPerspectivePose pose;
  const Matrix3d rotation = a.rotation.toRotationMatrix() * frame.plane_from_target;
  pose.scale_px_per_m = a.scale * spread.size / frame.size;
  Vector3d t = Vector3d::Zero();
  t.head<2>() = spread.mean / pose.scale_px_per_m - (rotation * frame.centre).head<2>();
  pose.camera_from_target = Pose(Quaterniond(rotation), t);
  return pose;
}

// Computed in the frames, so that a distant origin loses no digits.
double rms_of(const ScaledRotation& a, const PointSpread& frame, const Pixels& spread,
              std::span<const Vector3d> points, std::span<const Vector2d> pixels) {
  const Matrix23d affine = affine_of(a);
  double square = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    square += (affine * frame.in_plane(points[i]) * (spread.size / frame.size) -
               (pixels[i] - spread.mean))
                  .squaredNorm();
  return std::sqrt(square / static_cast<double>(points.size()));
}

}  // namespace

Solutions<WeakPerspectivePose, 2> weak_perspective_poses(
    std::span<const Vector3d> points, std::span<const Vector2d> pixels_from_centre) {
  if (points.size() != pixels_from_centre.size())
    throw Error("points and pixels: must be equally many");
  Solutions<WeakPerspectivePose, 2> poses;
  if (points.size() < 4) return poses;
  const PointSpread frame = spread_of(points);
  const Pixels spread = centred(pixels_from_centre);
  if (!frame.is_wide() || !(spread.size > 0) || !std::isfinite(spread.size)) return poses;
  const Moments m = moments_of(points, pixels_from_centre, frame, spread);

  Solutions<ScaledRotation, 3> minima;
  const bool flat = frame.thickness < kFlat;
  for (const ScaledRotation& start : plane_solutions(m))
    minima.push_back(flat ? start : refined(m, start));
  const bool space = frame.thickness >= kThin;
  if (space) minima.push_back(refined(m, space_start(m)));
  for (const ScaledRotation& minimum : minima) {
    WeakPerspectivePose pose = posed(minimum, frame, spread);
    pose.rms_px = rms_of(minimum, frame, spread, points, pixels_from_centre);
    if (!pose.camera_from_target.matrix().allFinite() || !std::isfinite(pose.rms_px)) continue;
    if (poses.empty()) {
      poses.push_back(pose);
    } else if (space) {
      if (pose.rms_px < poses[0].rms_px) poses[0] = pose;
    } else if (angle_between_rad(pose.camera_from_target, poses[0].camera_from_target) > kSameRad) {
      poses.push_back(pose);
    }
  }
  std::sort(poses.begin(), poses.end(),
            [](const auto& a, const auto& b) { return a.rms_px < b.rms_px; });
  return poses;
}

}  // namespace tagcal
