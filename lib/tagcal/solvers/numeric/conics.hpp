#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/solutions.hpp"

// Conics as symmetric matrices, their pencils, and where they meet.

namespace tagcal::internal {

inline Eigen::Matrix3d adjugate(const Eigen::Matrix3d& m) {  // of a symmetric matrix
  Eigen::Matrix3d a;
  a(0, 0) = m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2);
  a(1, 1) = m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2);
  a(2, 2) = m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1);
  a(0, 1) = a(1, 0) = m(0, 2) * m(1, 2) - m(0, 1) * m(2, 2);
  a(0, 2) = a(2, 0) = m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1);
  a(1, 2) = a(2, 1) = m(0, 1) * m(0, 2) - m(0, 0) * m(1, 2);
  return a;
}

inline double trace_of_product(const Eigen::Matrix3d& a,
                               const Eigen::Matrix3d& b) {  // of symmetric matrices
  return a(0, 0) * b(0, 0) + a(1, 1) * b(1, 1) + a(2, 2) * b(2, 2) +
         2 * (a(0, 1) * b(0, 1) + a(0, 2) * b(0, 2) + a(1, 2) * b(1, 2));
}

// det(f + g e) = c[0] + c[1] g + c[2] g^2 + c[3] g^3
struct Pencil {
  Eigen::Matrix3d e, f;
  double c[4] = {};

  Pencil(const Eigen::Matrix3d& e_, const Eigen::Matrix3d& f_) : e(e_), f(f_) {
    const Eigen::Matrix3d adj_e = adjugate(e), adj_f = adjugate(f);
    c[0] = f.row(0).dot(adj_f.row(0));
    c[1] = trace_of_product(adj_f, e);
    c[2] = trace_of_product(adj_e, f);
    c[3] = e.row(0).dot(adj_e.row(0));
  }
};

// Returns the same pencil with an e that is far from degenerate, so that no root of the cubic is
// large.
inline Pencil with_regular_end(const Pencil& pencil) {
  const double* c = pencil.c;
  const double largest = std::max({std::abs(c[0]), std::abs(c[1]), std::abs(c[2]), std::abs(c[3])});
  if (std::abs(c[3]) > 0.1 * largest) return pencil;
  if (std::abs(c[0]) > 0.1 * largest) return {pencil.f, pencil.e};
  const double sum = std::abs(c[0] + c[1] + c[2] + c[3]);
  const double difference = std::abs(c[0] - c[1] + c[2] - c[3]);
  const Eigen::Matrix3d s = pencil.e + pencil.f, d = pencil.f - pencil.e;
  return sum > difference ? Pencil(s, d) : Pencil(d, s);
}

// Returns the real root of a cubic that is farthest from the others: the largest t > 0 of
// t^3 + p t = |q| after the shift to their mean. Newton's method from above converges
// monotonically.
inline double isolated_root(const double* c) {
  const double mean = c[2] / (-3 * c[3]);
  const double p = c[1] / c[3] - 3 * mean * mean;
  const double q = c[0] / c[3] + mean * (c[1] / c[3] - 2 * mean * mean);
  const double target = std::abs(q);
  double t = std::cbrt(target);
  t = p < 0 ? t + std::sqrt(-p) : std::min(t, target / std::max(p, 1e-300));
  for (int i = 0; i < 50; ++i) {
    const double slope = 3 * t * t + p;
    const double step = (t * (t * t + p) - target) / slope;
    if (!(step > 4 * std::numeric_limits<double>::epsilon() * t)) break;
    t -= step;
  }
  return mean + std::copysign(t, -q);
}

// Splits a degenerate conic into its two lines: c + [x]_cross has rank one, for their intersection
// x, suitably scaled (Ding et al. 2023, section 3.2). False if they are not real.
inline bool split(const Eigen::Matrix3d& conic, Eigen::Vector3d& line_a, Eigen::Vector3d& line_b) {
  const Eigen::Matrix3d b = adjugate(conic);
  int i = 0;
  for (int j = 1; j < 3; ++j)
    if (b(j, j) < b(i, i)) i = j;
  if (std::max({b(0, 0), b(1, 1), b(2, 2)}) > 1e-6 * conic.squaredNorm()) return false;
  Eigen::Matrix3d m = conic;
  if (b(i, i) < 0) m += cross_matrix(b.col(i) / std::sqrt(-b(i, i)));
  Eigen::Index row = 0, col = 0;
  m.cwiseAbs().maxCoeff(&row, &col);
  line_a = m.row(row).transpose();
  line_b = m.col(col);
  return true;
}

// Returns the intersections of a line and a conic: two points at most, one if they nearly touch. A
// discriminant slightly below zero counts as zero, as it may be rounding; the caller decides.
inline Solutions<Eigen::Vector3d, 2> meet(const Eigen::Vector3d& line,
                                          const Eigen::Matrix3d& conic) {
  Eigen::Index k = 0;
  line.cwiseAbs().maxCoeff(&k);
  const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
  const double u = -line[i] / line[k], v = -line[j] / line[k];
  const double a = conic(i, i) + u * (2 * conic(i, k) + u * conic(k, k));
  const double b = conic(i, j) + u * conic(j, k) + v * (conic(i, k) + u * conic(k, k));
  const double c = conic(j, j) + v * (2 * conic(j, k) + v * conic(k, k));
  const double discriminant = b * b - a * c;
  Solutions<Eigen::Vector3d, 2> points;
  if (!(discriminant > -1e-4 * (b * b + std::abs(a * c)))) return points;
  const double root = -b - std::copysign(std::sqrt(std::max(discriminant, 0.0)), b);
  const auto add = [&](double x, double y) {
    Eigen::Vector3d point;
    point[i] = x;
    point[j] = y;
    point[k] = u * x + v * y;
    points.push_back(point);
  };
  add(root, a);
  if (discriminant > 0 || a == 0) add(c, root);
  return points;
}

}  // namespace tagcal::internal
