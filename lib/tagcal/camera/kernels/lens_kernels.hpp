#pragma once

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/camera/kernels/project_kernels.hpp"

// The formulas of lens.hpp for a pack of points at once: `Pack` is one double, or four in a
// register (pack_portable.hpp, pack_avx2.hpp). The single-point functions of the lenses are the
// definition; these agree with them to rounding.
//
// The namespace is unnamed although this is a header: each file of kernels has its own copy,
// compiled for its own processor.

namespace tagcal::internal {
namespace {

template <typename Pack>
struct PackPoint {
  Pack x, y, z;
};

template <typename Pack>
struct PackImage {
  Pack u, v;
  typename Pack::Mask valid;
};

// Derivatives of u (row 0) and v (row 1). `by_parameters` has room for sums behind the lens
// parameters. One object serves all packs of a job: the constant entries of
// d(u, v) / d(fx, fy, cx, cy) are set once at the start.
template <typename Pack>
struct PackJacobian {
  PackJacobian() {
    for (int i = 0; i < 4; ++i) {
      by_parameters[0][i] = Pack(i == kCx ? 1 : 0);
      by_parameters[1][i] = Pack(i == kCy ? 1 : 0);
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

// The constants of a job, in every lane.
template <typename Pack>
struct PackLens {
  explicit PackLens(const ViewJob& job) : limit(job.limit) {
    for (int i = 0; i < kMaxLensParameters; ++i) p[i] = Pack(job.parameters[i]);
  }

  Pack p[kMaxLensParameters];
  Pack limit;
};

// Perspective; Kind says which terms are not zero.
template <ProjectKernelKind Kind>
class PerspectiveKernel {
 public:
  template <typename Pack>
  static PackImage<Pack> project(const PackLens<Pack>& lens, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Pack* p = lens.p;
    const Distorted<Pack> d = distort(p, point.x / point.z, point.y / point.z);
    if (jacobian) {
      jacobian->set_focal_columns(d.xd, d.yd);
      by_point(p, d, Pack(1) / point.z, *jacobian);
      if constexpr (Kind != kPinhole) by_distortion(p, d, *jacobian);
    }
    return {fma(p[kFx], d.xd, p[kCx]), fma(p[kFy], d.yd, p[kCy]),
            (Pack(0) < point.z) & (d.s < lens.limit)};
  }

 private:
  template <typename Pack>
  struct Distorted {
    Pack x, y, s;              // s = x^2 + y^2
    Pack xy2, sx, sy;          // 2 x y, s + 2 x^2, s + 2 y^2
    Pack radial, denominator;  // L and its denominator
    Pack xd, yd;
  };

  template <typename Pack>
  static Distorted<Pack> distort(const Pack* p, Pack x, Pack y) {
    const Pack s = fma(x, x, y * y), one(1);
    if constexpr (Kind == kPinhole) return {x, y, s, one, one, one, one, one, x, y};
    Pack radial = fma(s, fma(s, fma(s, p[kK3], p[kK2]), p[kK1]), one), denominator = one;
    if constexpr (Kind == kRational) {
      denominator = fma(s, fma(s, fma(s, p[kK6], p[kK5]), p[kK4]), one);
      radial = radial / denominator;
    }
    const Pack xy2 = (x + x) * y, sx = fma(x + x, x, s), sy = fma(y + y, y, s);
    const Pack xd = fma(p[kP2], sx, fma(p[kP1], xy2, x * radial));
    const Pack yd = fma(p[kP1], sy, fma(p[kP2], xy2, y * radial));
    return {x, y, s, xy2, sx, sy, radial, denominator, xd, yd};
  }

  // The Jacobian of the distortion is ((xx, xy), (xy, yy)).
  template <typename Pack>
  static void by_point(const Pack* p, const Distorted<Pack>& d, Pack by_z, PackJacobian<Pack>& j) {
    Pack xx = d.radial, xy(0), yy = d.radial;
    if constexpr (Kind != kPinhole) {
      const Pack two(2), three(3);
      Pack slope = fma(d.s, fma(d.s, three * p[kK3], two * p[kK2]), p[kK1]);  // dL/ds
      if constexpr (Kind == kRational) {
        const Pack d1 = fma(d.s, fma(d.s, three * p[kK6], two * p[kK5]), p[kK4]);
        slope = (slope - d.radial * d1) / d.denominator;
      }
      const Pack along_x = two * slope * d.x, along_y = two * slope * d.y;
      const Pack p1_x = two * p[kP1] * d.x, p1_y = two * p[kP1] * d.y;
      const Pack p2_x = two * p[kP2] * d.x, p2_y = two * p[kP2] * d.y;
      xx = fma(along_x, d.x, d.radial) + fma(three, p2_x, p1_y);
      xy = fma(along_x, d.y, p1_x + p2_y);
      yy = fma(along_y, d.y, d.radial) + fma(three, p1_y, p2_x);
    }
    const Pack rows[2][2] = {{xx, xy}, {xy, yy}};
    for (int row = 0; row < 2; ++row) {
      const Pack scale = p[row] * by_z;  // p[row]: fx, fy
      j.by_point[row][0] = scale * rows[row][0];
      j.by_point[row][1] = scale * rows[row][1];
      j.by_point[row][2] = -(scale * fma(rows[row][0], d.x, rows[row][1] * d.y));
    }
  }

  template <typename Pack>
  static void by_distortion(const Pack* p, const Distorted<Pack>& d, PackJacobian<Pack>& j) {
    const Pack xy[2] = {d.x, d.y}, by_p1[2] = {d.xy2, d.sy}, by_p2[2] = {d.sx, d.xy2};
    for (int row = 0; row < 2; ++row) {
      Pack* column = j.by_parameters[row];
      Pack by_radial = p[row] * xy[row];
      if constexpr (Kind == kRational) by_radial = by_radial / d.denominator;
      column[kK1] = d.s * by_radial;
      column[kK2] = d.s * column[kK1];
      column[kK3] = d.s * column[kK2];
      column[kP1] = p[row] * by_p1[row];
      column[kP2] = p[row] * by_p2[row];
      if constexpr (Kind == kRational) {
        column[kK4] = -(d.radial * column[kK1]);
        column[kK5] = d.s * column[kK4];
        column[kK6] = d.s * column[kK5];
      }
    }
  }
};

// atan2(radius, z) for radius >= 0, to an ulp or so. The angle is turned by 0, 1/4 pi or 1/2 pi to
// within pi/8 of an axis, where atan(q) = q + q^3 P(q^2); P interpolates at the Chebyshev nodes to
// 7e-18 of the result.
template <typename Pack>
Pack angle_from_axis(Pack radius, Pack z) {
  const Pack kTan(0.41421356237309503);  // tan(pi/8)
  const Pack depth = abs(z);
  const auto near = radius < depth * kTan;
  const auto beside = depth < radius * kTan;
  const Pack numerator = select(near, radius, select(beside, -depth, radius - depth));
  const Pack denominator = select(near, depth, select(beside, radius, radius + depth));
  const Pack q = numerator / denominator;
  const Pack s = q * q;
  constexpr double kCoefficients[] = {
      -0.019176887116097312, 0.03923165829316618, -0.05085449737856458, 0.05858148912786196,
      -0.06664511447380105,  0.07692183190825956, -0.09090904578123896, 0.11111111015256361,
      -0.14285714284666542,  0.1999999999999552,  -0.3333333333333333};
  Pack sum(kCoefficients[0]);
  for (int i = 1; i < 11; ++i) sum = fma(sum, s, Pack(kCoefficients[i]));
  const Pack angle = fma(q * s, sum, q);
  // Multiples of pi/4 in two parts: the second is what the double nearest to it lacks.
  constexpr double kQuarter = 0.78539816339744830962, kQuarterRest = 3.061616997868383e-17;
  const Pack turn = select(near, Pack(0), select(beside, Pack(2), Pack(1)));
  const Pack in_front = fma(turn, Pack(kQuarter), fma(turn, Pack(kQuarterRest), angle));
  const Pack behind = (Pack(4 * kQuarter) - in_front) + Pack(4 * kQuarterRest);
  return select(z < Pack(0), behind, in_front);
}

class FisheyeKernel {
 public:
  template <typename Pack>
  static PackImage<Pack> project(const PackLens<Pack>& lens, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Pack* p = lens.p;
    const Pack one(1), zero(0);
    // The image depends on the direction only: points whose squares would leave the range of double
    // are brought to size 1. What is zero, infinite or NaN becomes NaN and fails the last test.
    const Pack size = max(max(abs(point.x), abs(point.y)), abs(point.z));
    const auto plain = (Pack(1e-100) < size) & (size < Pack(1e100));
    Pack unit = one, x = point.x, y = point.y, z = point.z;
    if (!all(plain)) {
      unit = select(plain, one, size);
      x = x / unit;
      y = y / unit;
      z = z / unit;
    }
    const Pack square = fma(x, x, y * y);
    const Pack radius = sqrt(square);
    const auto off_axis = zero < radius;
    const Pack theta = angle_from_axis(radius, z);
    const Pack s = theta * theta;
    const Pack stretch =
        fma(s, fma(s, fma(s, fma(s, p[7], p[6]), p[5]), p[4]), one);  // theta_d / theta
    const Pack theta_d = theta * stretch;
    const Pack scale =  // theta_d / radius, its limit on the axis
        select(off_axis, theta_d, one) / select(off_axis, radius, z);
    const Pack xd = scale * x, yd = scale * y;
    if (jacobian) {
      jacobian->set_focal_columns(xd, yd);
      const Pack by_radius = select(off_axis, one / radius, zero);
      const PackPoint<Pack> direction = {x * by_radius, y * by_radius, z / fma(z, z, square)};
      const Angle<Pack> angle = {theta, s, radius / fma(z, z, square), scale, one / unit};
      jacobian_at(p, angle, direction, *jacobian);
    }
    return {fma(p[0], xd, p[2]), fma(p[1], yd, p[3]), theta < lens.limit};
  }

 private:
  template <typename Pack>
  struct Angle {
    Pack theta, s;
    Pack minus_by_z;  // -d(theta)/dZ
    Pack scale;       // theta_d / radius
    Pack by_unit;
  };

  // `direction`: (X, Y) / radius and d(theta)/d(radius).
  template <typename Pack>
  static void jacobian_at(const Pack* p, const Angle<Pack>& angle, const PackPoint<Pack>& direction,
                          PackJacobian<Pack>& d) {
    const Pack s = angle.s;
    const Pack slope = fma(
        s, fma(s, fma(s, fma(s, Pack(9) * p[7], Pack(7) * p[6]), Pack(5) * p[5]), Pack(3) * p[4]),
        Pack(1));  // d(theta_d)/d(theta)
    const Pack across = fma(slope, direction.z, -angle.scale);
    const Pack xy[2] = {direction.x, direction.y};
    for (int row = 0; row < 2; ++row) {
      const Pack focal = p[row] * angle.by_unit;
      const Pack along = across * xy[row];
      d.by_point[row][0] = focal * fma(along, xy[0], row == 0 ? angle.scale : Pack(0));
      d.by_point[row][1] = focal * fma(along, xy[1], row == 1 ? angle.scale : Pack(0));
      d.by_point[row][2] = -(focal * slope * angle.minus_by_z * xy[row]);
      Pack power = p[row] * xy[row] * angle.theta;
      for (int i = 4; i < 8; ++i) {
        power = power * s;
        d.by_parameters[row][i] = power;
      }
    }
  }
};

struct ParallelKernel {
  template <typename Pack>
  static PackImage<Pack> project(const PackLens<Pack>& lens, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Pack* p = lens.p;
    const Pack infinity(__builtin_inf());
    if (jacobian) {
      jacobian->set_focal_columns(point.x, point.y);
      for (int row = 0; row < 2; ++row)
        for (int i = 0; i < 3; ++i) jacobian->by_point[row][i] = row == i ? p[row] : Pack(0);
    }
    return {fma(p[0], point.x, p[2]), fma(p[1], point.y, p[3]),
            (abs(point.x) < infinity) & (abs(point.y) < infinity) & (abs(point.z) < infinity)};
  }
};

}  // namespace
}  // namespace tagcal::internal
