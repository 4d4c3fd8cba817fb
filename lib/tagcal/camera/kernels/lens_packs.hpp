#pragma once

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/camera/kernels/project_kernels.hpp"
#include "tagcal/internal/pack.hpp"

// Points, pixels and derivatives of a pack, which all kernels of lenses share. A file that
// includes this has its own copy (see internal/pack.hpp).

namespace tagcal::internal {
namespace {

template <typename Pack>
struct PackPoint {
  Pack x, y, z;
};

template <typename Pack>
struct PackImage {
  Pack u, v;
  Mask<Pack> valid;
};

// Derivatives of u (row 0) and v (row 1). `by_parameters` has room for sums behind the lens
// parameters. One object serves all packs of a job: the constant entries of
// d(u, v) / d(fx, fy, cx, cy) are set once at the start.
template <typename Pack>
struct PackJacobian {
  PackJacobian() {
    for (int i = 0; i < 4; ++i) {
      by_parameters[0][i] = splat<Pack>(i == kCx ? 1.0 : 0.0);
      by_parameters[1][i] = splat<Pack>(i == kCy ? 1.0 : 0.0);
    }
  }

  // x and y of u = fx x + cx, v = fy y + cy.
  void set_focal_columns(Pack x, Pack y) {
    by_parameters[0][kFx] = x;
    by_parameters[1][kFy] = y;
  }

  Pack by_point[2][3];
  Pack by_parameters[2][2 * kMaxLensParameters];
};

// atan2(radius, z) for radius >= 0, to an ulp or so. The angle is turned by 0, 1/4 pi or 1/2 pi to
// within pi/8 of an axis, where atan(q) = q + q^3 P(q^2); P interpolates at the Chebyshev nodes to
// 7e-18 of the result.
template <typename Pack>
Pack angle_from_axis(Pack radius, Pack z) {
  constexpr double kTan = 0.41421356237309503;  // tan(pi/8)
  const Pack depth = magnitude(z);
  const Mask<Pack> near = radius < depth * kTan, beside = depth < radius * kTan;
  const Pack numerator = near ? radius : beside ? -depth : radius - depth;
  const Pack denominator = near ? depth : beside ? radius : radius + depth;
  const Pack q = numerator / denominator;
  const Pack s = q * q;
  constexpr double kCoefficients[] = {
      -0.019176887116097312, 0.03923165829316618, -0.05085449737856458, 0.05858148912786196,
      -0.06664511447380105,  0.07692183190825956, -0.09090904578123896, 0.11111111015256361,
      -0.14285714284666542,  0.1999999999999552,  -0.3333333333333333};
  Pack sum = splat<Pack>(kCoefficients[0]);
  for (int i = 1; i < 11; ++i) sum = sum * s + kCoefficients[i];
  const Pack angle = q * s * sum + q;
  // Multiples of pi/4 in two parts: the second is what the double nearest to it lacks.
  constexpr double kQuarter = 0.78539816339744830962, kQuarterRest = 3.061616997868383e-17;
  const Pack one = splat<Pack>(1.0), turn = near ? Pack{} : beside ? one + one : one;
  const Pack in_front = turn * kQuarter + (turn * kQuarterRest + angle);
  const Pack behind = (4 * kQuarter - in_front) + 4 * kQuarterRest;
  return z < 0.0 ? behind : in_front;
}

// A point, over `unit`. The image depends on the direction only: points whose squares would leave
// the range of double are brought to size 1. What is zero, infinite or NaN becomes NaN, and is in
// no domain.
template <typename Pack>
struct ScaledPoint {
  Pack x, y, z, unit;

  explicit ScaledPoint(const PackPoint<Pack>& point)
      : x(point.x), y(point.y), z(point.z), unit(splat<Pack>(1.0)) {
    const Pack size = larger(larger(magnitude(x), magnitude(y)), magnitude(z));
    const Mask<Pack> plain = (1e-100 < size) & (size < 1e100);
    if (all_set(plain)) return;
    unit = plain ? unit : size;
    x = x / unit;
    y = y / unit;
    z = z / unit;
  }
};

}  // namespace
}  // namespace tagcal::internal
