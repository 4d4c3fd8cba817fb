#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tagcal/solvers/numeric/conics.hpp"
#include "tagcal/solvers/p3p.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The triangle, in units of its longest side, from corner 0 to corner 1. Coordinates are relative
// to corner 2, so that the origin of the target has no effect. The unknowns
//   p = d0 - d2, r = d1 - d2, w = chord d2
// of the distances d along the unit rays make the three equations
//   side02: p^2 + k02 (w^2 + chord p w) = alpha
//   side12: r^2 + k12 (w^2 + chord r w) = beta
//   side01: (p - r)^2 + k01 (w + chord p)(w + chord r) = 1
// with k = |m_i - m_j|^2 / chord^2 free of cancellation however far the triangle is.
struct Triangle {
  Vector3d corner[3];  // in the target frame
  Vector3d ray[3];     // unit length
  Vector3d side02, side12;
  double length = 0;           // of the longest side
  double alpha = 0, beta = 0;  // |side02|^2, |side12|^2
  double chord = 0;            // the largest |m_i - m_j|
  double k01 = 0, k02 = 0, k12 = 0;
};

// (p, r, w), or the projective point (p : r : w).
using Unknowns = Vector3d;

// False if the height of the triangle is below the rounding of the coordinates.
bool has_area(const Triangle& problem, double largest_coordinate) {
  const double rounding = std::max(1e-9, 16 * std::numeric_limits<double>::epsilon() *
                                             largest_coordinate / problem.length);  // of the length
  return problem.side02.cross(problem.side12).squaredNorm() > rounding * rounding;
}

bool set_triangle(std::span<const Vector3d, 3> points, std::span<const Vector3d, 3> rays,
                  Triangle& problem) {
  double scale = 0, largest_coordinate = 0;
  for (int i = 0; i < 3; ++i) {
    largest_coordinate = std::max(largest_coordinate, points[i].cwiseAbs().maxCoeff());
    scale = std::max(scale, (points[(i + 1) % 3] - points[i]).cwiseAbs().maxCoeff());
  }
  if (!(scale > 0 && 1 / scale > 0 && 1 / scale <= std::numeric_limits<double>::max()))
    return false;
  Vector3d sides[3];
  double length2[3];
  for (int i = 0; i < 3; ++i) {
    sides[i] = (points[(i + 2) % 3] - points[(i + 1) % 3]) / scale;  // opposite corner i
    length2[i] = sides[i].squaredNorm();
  }
  const int last = length2[0] > length2[1] ? (length2[0] > length2[2] ? 0 : 2)
                                           : (length2[1] > length2[2] ? 1 : 2);
  const int order[3] = {(last + 1) % 3, (last + 2) % 3, last};
  for (int i = 0; i < 3; ++i) {
    problem.corner[i] = points[order[i]];
    problem.ray[i] = rays[order[i]].stableNormalized();
    if (!(problem.ray[i].squaredNorm() > 0.5)) return false;
  }
  const double length = std::sqrt(length2[last]);
  problem.length = length * scale;
  problem.side02 = sides[order[1]] / length;
  problem.side12 = sides[order[0]] / -length;
  problem.alpha = problem.side02.squaredNorm();
  problem.beta = problem.side12.squaredNorm();
  return has_area(problem, largest_coordinate);
}

bool set_angles(Triangle& problem) {
  const Vector3d* m = problem.ray;
  const double c01 = (m[0] - m[1]).squaredNorm(), c02 = (m[0] - m[2]).squaredNorm(),
               c12 = (m[1] - m[2]).squaredNorm();
  const double largest = std::max({c01, c02, c12});
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  if (!(largest > 16 * kRounding * kRounding)) return false;
  problem.chord = std::sqrt(largest);
  problem.k01 = c01 / largest;
  problem.k02 = c02 / largest;
  problem.k12 = c12 / largest;
  return true;
}

// The conics side02 - alpha side01 = 0 and side12 - beta side01 = 0 in (p : r : w).
std::pair<Matrix3d, Matrix3d> conics(const Triangle& problem) {
  const double k01 = problem.k01;
  const double half = problem.chord / 2, mixed = 1 - 2 * half * half * k01;
  const auto conic = [&](const Vector3d& square, double k, double share) {
    const double pw = half * (square.x() * k - share * k01);
    const double rw = half * (square.y() * k - share * k01);
    Matrix3d m;
    m << square.x() - share, share * mixed, pw,  //
        share * mixed, square.y() - share, rw,   //
        pw, rw, k - share * k01;
    return m;
  };
  return {conic(Vector3d::UnitX(), problem.k02, problem.alpha),
          conic(Vector3d::UnitY(), problem.k12, problem.beta)};
}

Vector3d residual_of(const Triangle& problem, const Unknowns& x) {
  const double s = problem.chord, p = x[0], r = x[1], w = x[2];
  return {p * p + problem.k02 * w * (w + s * p) - problem.alpha,
          r * r + problem.k12 * w * (w + s * r) - problem.beta,
          (p - r) * (p - r) + problem.k01 * (w + s * p) * (w + s * r) - 1};
}

// J^-1 residual
Vector3d newton_step(const Triangle& problem, const Unknowns& x, const Vector3d& residual) {
  const double s = problem.chord, p = x[0], r = x[1], w = x[2];
  Matrix3d jacobian;
  jacobian << 2 * p + problem.k02 * s * w, 0, problem.k02 * (2 * w + s * p),  //
      0, 2 * r + problem.k12 * s * w, problem.k12 * (2 * w + s * r),          //
      2 * (p - r) + problem.k01 * s * (w + s * r), 2 * (r - p) + problem.k01 * s * (w + s * p),
      problem.k01 * (2 * w + s * (p + r));
  return jacobian.inverse() * residual;
}

// Newton's method while the error decreases. False if it does not solve the equations.
bool polish(const Triangle& problem, Unknowns& x) {
  Vector3d residual = residual_of(problem, x);
  double error = residual.squaredNorm();
  constexpr double kExact = 4e-32;  // two roundings of the unit side, squared
  for (int i = 0; i < 10 && error > kExact; ++i) {
    const Unknowns next = x - newton_step(problem, x, residual);
    const Vector3d next_residual = residual_of(problem, next);
    const double next_error = next_residual.squaredNorm();
    if (!(next_error < error)) break;
    x = next;
    residual = next_residual;
    error = next_error;
  }
  return error < 1e-22;
}

// Turns a projective point into distances that solve the equations, all in front.
bool solve_from(const Triangle& problem, Unknowns& x) {
  const double s = problem.chord;
  const double unit =
      (x[0] - x[1]) * (x[0] - x[1]) + problem.k01 * (x[2] + s * x[0]) * (x[2] + s * x[1]);
  if (!(unit > 0)) return false;
  x *= std::copysign(1 / std::sqrt(unit), x[2]);
  const auto in_front = [&](double least) {
    return x[2] > least && x[2] + s * x[0] > least && x[2] + s * x[1] > least;
  };
  return in_front(-1e-6) && polish(problem, x) && in_front(0);
}

// Frame with columns along a - b, in the plane of a and b, and normal to it.
Matrix3d frame_of(const Vector3d& a, const Vector3d& b) {
  Matrix3d frame;
  frame.col(0) = (a - b).normalized();
  frame.col(2) = a.cross(b).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

// Adds the pose if the triangle lies on its rays to 1e-9. Rounding may prevent this for a triangle
// that is within 1e-6 of its size of the camera, or as thin.
void add_pose(const Triangle& problem, const Matrix3d& target_frame, const Unknowns& x,
              Solutions<Pose, 4>& poses) {
  const double d2 = x[2] / problem.chord, d0 = d2 + x[0], d1 = d2 + x[1];
  const Vector3d* m = problem.ray;
  const Vector3d side02 = x[0] * m[0] + d2 * (m[0] - m[2]),
                 side12 = x[1] * m[1] + d2 * (m[1] - m[2]);
  const Matrix3d rotation = frame_of(side02, side12) * target_frame.transpose();
  constexpr double kLargestAngle2 = 2.5e-19;  // half of 1e-9, squared
  if (!((rotation * problem.side02 - side02).squaredNorm() < kLargestAngle2 * d0 * d0 &&
        (rotation * problem.side12 - side12).squaredNorm() < kLargestAngle2 * d1 * d1))
    return;
  const Pose turned(Eigen::Quaterniond(rotation), Vector3d::Zero());
  poses.push_back({turned.rotation(), problem.length * d2 * m[2] - turned * problem.corner[2]});
}

bool contains(const Solutions<Unknowns, 4>& found, const Unknowns& x) {
  return std::any_of(found.begin(), found.end(),
                     [&x](const Unknowns& other) { return (other - x).squaredNorm() < 1e-20; });
}

}  // namespace

Solutions<Pose, 4> p3p(std::span<const Vector3d, 3> points, std::span<const Vector3d, 3> rays) {
  Solutions<Pose, 4> poses;
  Triangle problem;
  if (!set_triangle(points, rays, problem) || !set_angles(problem)) return poses;
  const auto [e, f] = conics(problem);
  const Pencil pencil = with_regular_end(Pencil(e, f));
  const double g = isolated_root(pencil.c);
  Vector3d lines[2];
  if (!split(pencil.f + g * pencil.e, lines[0], lines[1])) return poses;
  Solutions<Unknowns, 4> found;
  for (const Vector3d& line : lines)
    for (Unknowns x : meet(line, std::abs(g) < 1 ? pencil.e : pencil.f))
      if (solve_from(problem, x) && !contains(found, x)) found.push_back(x);
  const Matrix3d target_frame = frame_of(problem.side02, problem.side12);
  for (const Unknowns& x : found) add_pose(problem, target_frame, x, poses);
  return poses;
}

}  // namespace tagcal
