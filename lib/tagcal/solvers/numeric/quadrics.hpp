#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "tagcal/solvers/numeric/real_roots.hpp"

// Intersection of four quadrics in three unknowns. As there are more equations than unknowns,
// elimination alone leaves one unknown.

namespace tagcal::internal {

// Four quadrics in the unknowns (x, y, z): one row each, the coefficients of these monomials.
enum Monomial { kXX, kYY, kXY, kXZ, kYZ, kX, kY, kZZ, kZ, kOne, kNumMonomials };
using QuadricRow = Eigen::Matrix<double, 1, kNumMonomials>;
using Quadrics = Eigen::Matrix<double, 4, kNumMonomials>;

// Gauss-Jordan elimination: the rows 0 to 2 become x^2 + ..., y^2 + ..., x y + ..., row 3 has none
// of them. Returns the smallest pivot over the largest coefficient, which is small if z is a bad
// choice for the remaining unknown.
inline double eliminate(Quadrics& q) {
  double smallest = std::numeric_limits<double>::infinity();
  const double largest = q.leftCols<3>().cwiseAbs().maxCoeff();
  for (Eigen::Index col = 0; col < 3; ++col) {
    Eigen::Index pivot = col;
    for (Eigen::Index i = col + 1; i < 4; ++i)
      if (std::abs(q(i, col)) > std::abs(q(pivot, col))) pivot = i;
    const double value = q(pivot, col);
    smallest = std::min(smallest, std::abs(value));
    if (!(std::abs(value) > 1e-12 * largest)) return 0;
    if (pivot != col) q.row(pivot).swap(q.row(col));
    Eigen::Vector4d factor = q.col(col) / value;
    factor[col] = 1 - 1 / value;
    for (Eigen::Index j = col + 1; j < kNumMonomials; ++j) {
      const double of_pivot = q(col, j);
      q.col(j) -= factor * of_pivot;
    }
  }
  return smallest / largest;
}

// x, y, 1 with coefficients that are polynomials in z.
template <std::size_t N>
struct Linear {
  FixedPolynomial<N> x, y;
  FixedPolynomial<N + 1> one;

  Eigen::Vector3d operator()(double z) const { return {x(z), y(z), one(z)}; }
  double largest() const { return std::max({x.largest(), y.largest(), one.largest()}); }
};

inline Linear<1> linear_part(const Quadrics& q, Eigen::Index row, double sign) {
  return {{{sign * q(row, kX), sign * q(row, kXZ)}},
          {{sign * q(row, kY), sign * q(row, kYZ)}},
          {{sign * q(row, kOne), sign * q(row, kZ), sign * q(row, kZZ)}}};
}

// The equation that is linear in x and y, and its products with x and y, reduced to linear ones: a
// 3 x 3 matrix of polynomials in z with the null vector (x, y, 1).
struct Resultant {
  Linear<1> first;
  Linear<2> times_x, times_y;
  FixedPolynomial<6> determinant;

  // True if the determinant is zero for every z, except for rounding: another unknown must remain.
  bool is_degenerate() const {
    const double scale = first.largest() * times_x.largest() * times_y.largest();
    return !(determinant.largest() > 1e-11 * scale);
  }
};

inline Resultant resultant_of(const Quadrics& q) {
  const Linear<1> xx = linear_part(q, 0, -1), yy = linear_part(q, 1, -1),
                  xy = linear_part(q, 2, -1);
  Resultant r;
  const Linear<1>& l = r.first = linear_part(q, 3, 1);
  r.times_x = {l.x * xx.x + l.y * xy.x + l.one, l.x * xx.y + l.y * xy.y,
               l.x * xx.one + l.y * xy.one};
  r.times_y = {l.x * xy.x + l.y * yy.x, l.x * xy.y + l.y * yy.y + l.one,
               l.x * xy.one + l.y * yy.one};
  const Linear<2>&a = r.times_x, &b = r.times_y;
  r.determinant = l.x * (a.y * b.one - b.y * a.one) - l.y * (a.x * b.one - b.x * a.one) +
                  l.one * (a.x * b.y - b.x * a.y);
  return r;
}

inline bool unknowns_at(const Resultant& r, double z, Eigen::Vector3d& xi) {
  const Eigen::Vector3d a = r.first(z), b = r.times_x(z), c = r.times_y(z);
  const Eigen::Vector3d ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
  const Eigen::Vector3d& larger = ab.squaredNorm() > ca.squaredNorm() ? ab : ca;
  const Eigen::Vector3d& null = larger.squaredNorm() > bc.squaredNorm() ? larger : bc;
  xi = {null.x() / null.z(), null.y() / null.z(), z};
  return std::isfinite(xi.x() + xi.y());
}

// Gauss-Newton step on the quadrics, and the sum of their squares before it.
struct Step {
  Eigen::Vector3d step;
  double error = 0;
};

inline Step step_at(const Quadrics& q, const Eigen::Vector3d& xi) {
  using Column = Eigen::Vector4d;
  const double x = xi.x(), y = xi.y(), z = xi.z();
  const Column jx = q.col(kXX) * (2 * x) + q.col(kXY) * y + q.col(kXZ) * z + q.col(kX);
  const Column jy = q.col(kXY) * x + q.col(kYY) * (2 * y) + q.col(kYZ) * z + q.col(kY);
  const Column jz = q.col(kXZ) * x + q.col(kYZ) * y + q.col(kZZ) * (2 * z) + q.col(kZ);
  const Column e =
      ((jx + q.col(kX)) * x + (jy + q.col(kY)) * y + (jz + q.col(kZ)) * z) / 2 + q.col(kOne);
  // Solves the normal equations by the cofactors of their symmetric matrix.
  const double xx = jx.squaredNorm(), xy = jx.dot(jy), xz = jx.dot(jz), yy = jy.squaredNorm(),
               yz = jy.dot(jz), zz = jz.squaredNorm();
  const Eigen::Vector3d cx(yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
  const double cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
  const double determinant = xx * cx[0] + xy * cx[1] + xz * cx[2];
  const Eigen::Vector3d b(jx.dot(e), jy.dot(e), jz.dot(e));
  const Eigen::Vector3d numerator(cx.dot(b), cx[1] * b[0] + cyy * b[1] + cyz * b[2],
                                  cx[2] * b[0] + cyz * b[1] + czz * b[2]);
  return {numerator / determinant, e.squaredNorm()};
}

}  // namespace tagcal::internal
