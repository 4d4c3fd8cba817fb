#pragma once

#include "tagcal/camera/kernels/lens_packs.hpp"

// The formulas of lens.hpp, for a pack of points or for one point: the lenses and the loops of
// kernels have them from here. A file that includes this has its own copy (see internal/pack.hpp).

namespace tagcal::internal {
namespace {

// Perspective; Kind says which terms are not zero. `limit` is max_radius^2.
template <ProjectKernelKind Kind>
struct PerspectiveKernel {
  template <typename Pack>
  struct Distorted {
    Pack x, y, s;              // s = x^2 + y^2
    Pack radial, denominator;  // L and its denominator
    Pack xd, yd;
  };

  template <typename Pack>
  struct Symmetric {
    Pack xx, xy, yy;
  };

  template <typename Pack, typename Number>
  static PackImage<Pack> project(const Number* p, Number limit, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Distorted<Pack> d = distort(p, point.x / point.z, point.y / point.z);
    if (jacobian) {
      jacobian->set_focal_columns(d.xd, d.yd);
      by_point(p, d, 1.0 / point.z, *jacobian);
      if constexpr (Kind != kPinhole) by_distortion(p, d, *jacobian);
    }
    const Mask<Pack> valid = (0.0 < point.z) & (d.s < limit);
    return {p[kFx] * d.xd + p[kCx], p[kFy] * d.yd + p[kCy], valid};
  }

  template <typename Pack, typename Number>
  static Distorted<Pack> distort(const Number* p, Pack x, Pack y) {
    const Pack s = x * x + y * y, one = splat<Pack>(1.0);
    if constexpr (Kind == kPinhole) return {x, y, s, one, one, x, y};
    Pack radial = 1.0 + s * (p[kK1] + s * (p[kK2] + s * p[kK3])), denominator = one;
    if constexpr (Kind == kRational) {
      denominator = 1.0 + s * (p[kK4] + s * (p[kK5] + s * p[kK6]));
      radial = radial / denominator;
    }
    const Pack xd = x * radial + 2.0 * p[kP1] * (x * y) + p[kP2] * (s + 2.0 * (x * x));
    const Pack yd = y * radial + p[kP1] * (s + 2.0 * (y * y)) + 2.0 * p[kP2] * (x * y);
    return {x, y, s, radial, denominator, xd, yd};
  }

  // dL/ds
  template <typename Pack, typename Number>
  static Pack radial_slope(const Number* p, const Distorted<Pack>& d) {
    const Pack slope = p[kK1] + d.s * (2.0 * p[kK2] + d.s * (3.0 * p[kK3]));
    if constexpr (Kind != kRational) return slope;
    const Pack of_denominator = p[kK4] + d.s * (2.0 * p[kK5] + d.s * (3.0 * p[kK6]));
    return (slope - d.radial * of_denominator) / d.denominator;
  }

  // d(x', y') / d(x, y) of a lens with distortion
  template <typename Pack, typename Number>
  static Symmetric<Pack> distortion_jacobian(const Number* p, const Distorted<Pack>& d) {
    const Pack slope = 2.0 * radial_slope(p, d), along_x = slope * d.x, along_y = slope * d.y;
    const Number p1 = 2.0 * p[kP1], p2 = 2.0 * p[kP2];
    return {d.radial + along_x * d.x + p1 * d.y + 3.0 * p2 * d.x,
            along_x * d.y + p1 * d.x + p2 * d.y,
            d.radial + along_y * d.y + 3.0 * p1 * d.y + p2 * d.x};
  }

 private:
  template <typename Pack, typename Number>
  static void by_point(const Number* p, const Distorted<Pack>& d, Pack by_z,
                       PackJacobian<Pack>& j) {
    Symmetric<Pack> a = {d.radial, Pack{}, d.radial};
    if constexpr (Kind != kPinhole) a = distortion_jacobian(p, d);
    const Pack rows[2][2] = {{a.xx, a.xy}, {a.xy, a.yy}};
    for (int row = 0; row < 2; ++row) {
      const Pack scale = p[row] * by_z;  // p[row]: fx, fy
      j.by_point[row][0] = scale * rows[row][0];
      j.by_point[row][1] = scale * rows[row][1];
      j.by_point[row][2] = -(scale * (rows[row][0] * d.x + rows[row][1] * d.y));
    }
  }

  template <typename Pack, typename Number>
  static void by_distortion(const Number* p, const Distorted<Pack>& d, PackJacobian<Pack>& j) {
    const Pack xy[2] = {d.x, d.y}, twice = 2.0 * (d.x * d.y);
    const Pack by_p1[2] = {twice, d.s + 2.0 * (d.y * d.y)};
    const Pack by_p2[2] = {d.s + 2.0 * (d.x * d.x), twice};
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

// `limit` is max_angle.
struct FisheyeKernel {
  template <typename Pack, typename Number>
  static PackImage<Pack> project(const Number* p, Number limit, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Pack one = splat<Pack>(1.0);
    const ScaledPoint<Pack> scaled(point);
    const Pack x = scaled.x, y = scaled.y, z = scaled.z;
    const Pack square = x * x + y * y;
    const Pack radius = square_root(square);
    const Mask<Pack> off_axis = 0.0 < radius;
    const Pack theta = angle_from_axis(radius, z);
    const Pack scale =  // theta_d / radius, its limit on the axis
        (off_axis ? distorted(p, theta) : one) / (off_axis ? radius : z);
    const Pack xd = scale * x, yd = scale * y;
    if (jacobian) {
      jacobian->set_focal_columns(xd, yd);
      const Pack by_radius = off_axis ? 1.0 / radius : Pack{};
      const PackPoint<Pack> direction = {x * by_radius, y * by_radius, z / (z * z + square)};
      const Angle<Pack> angle = {theta, radius / (z * z + square), scale, 1.0 / scaled.unit};
      jacobian_at(p, angle, direction, *jacobian);
    }
    return {p[kFx] * xd + p[kCx], p[kFy] * yd + p[kCy], theta < limit};
  }

  // theta_d
  template <typename Pack, typename Number>
  static Pack distorted(const Number* p, Pack theta) {
    const Pack s = theta * theta;
    return theta * (1.0 + s * (p[4] + s * (p[5] + s * (p[6] + s * p[7]))));
  }

  // d(theta_d)/d(theta)
  template <typename Pack, typename Number>
  static Pack slope(const Number* p, Pack theta) {
    const Pack s = theta * theta;
    return 1.0 + s * (3 * p[4] + s * (5 * p[5] + s * (7 * p[6] + s * (9 * p[7]))));
  }

 private:
  template <typename Pack>
  struct Angle {
    Pack theta;
    Pack minus_by_z;  // -d(theta)/dZ
    Pack scale;       // theta_d / radius
    Pack by_unit;
  };

  // `direction`: (X, Y) / radius and d(theta)/d(radius).
  template <typename Pack, typename Number>
  static void jacobian_at(const Number* p, const Angle<Pack>& angle,
                          const PackPoint<Pack>& direction, PackJacobian<Pack>& d) {
    const Pack slope_here = slope(p, angle.theta);
    const Pack across = slope_here * direction.z - angle.scale;
    const Pack xy[2] = {direction.x, direction.y};
    for (int row = 0; row < 2; ++row) {
      const Pack focal = p[row] * angle.by_unit;
      const Pack along = across * xy[row];
      d.by_point[row][0] = focal * (row == 0 ? along * xy[0] + angle.scale : along * xy[0]);
      d.by_point[row][1] = focal * (row == 1 ? along * xy[1] + angle.scale : along * xy[1]);
      d.by_point[row][2] = -(focal * slope_here * angle.minus_by_z * xy[row]);
      Pack power = p[row] * xy[row] * angle.theta;
      for (int i = 4; i < 8; ++i) {
        power = power * (angle.theta * angle.theta);
        d.by_parameters[row][i] = power;
      }
    }
  }
};

// The rest of a lens (u, v) = (fx X, fy Y) / D + (cx, cy), and its derivatives by those of D.
template <typename Pack>
struct Denominator {
  Pack value;
  Pack by_radius, by_z;      // dD / dX = by_radius X, dD / dY = by_radius Y; dD / dZ
  Pack by_first, by_second;  // by the two parameters behind cx, cy

  template <typename Number>
  PackImage<Pack> image(const Number* p, const ScaledPoint<Pack>& point, Mask<Pack> valid,
                        PackJacobian<Pack>* jacobian) const {
    const Pack scale = 1.0 / value, xy[2] = {point.x, point.y};
    const Pack at[2] = {scale * point.x, scale * point.y};
    if (jacobian) {
      jacobian->set_focal_columns(at[0], at[1]);
      for (int row = 0; row < 2; ++row) {
        const Pack focal = p[row] * scale, along = p[row] * scale / point.unit;
        for (int i = 0; i < 2; ++i) {
          const Pack turned = -(at[row] * by_radius * xy[i]);
          jacobian->by_point[row][i] = along * (row == i ? 1.0 + turned : turned);
        }
        jacobian->by_point[row][2] = -(along * at[row] * by_z);
        jacobian->by_parameters[row][4] = -(focal * at[row] * by_first);
        jacobian->by_parameters[row][5] = -(focal * at[row] * by_second);
      }
    }
    return {p[kFx] * at[0] + p[kCx], p[kFy] * at[1] + p[kCy], valid};
  }
};

// `limit` is w.
struct DoubleSphereKernel {
  template <typename Pack, typename Number>
  static PackImage<Pack> project(const Number* p, Number limit, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const ScaledPoint<Pack> at(point);
    const Number xi = p[4], alpha = p[5];
    const Pack square = at.x * at.x + at.y * at.y;
    const Pack d1 = square_root(square + at.z * at.z), z2 = xi * d1 + at.z;
    const Pack d2 = square_root(square + z2 * z2);
    const Pack by_z2 = alpha * (z2 / d2) + (1.0 - alpha);  // of D
    const Denominator<Pack> d = {alpha * d2 + (1.0 - alpha) * z2, alpha / d2 + by_z2 * (xi / d1),
                                 by_z2 * (xi * (at.z / d1) + 1.0), by_z2 * d1, d2 - z2};
    return d.image(p, at, -(limit * d2) < z2, jacobian);
  }
};

// `limit` is w.
struct ExtendedUnifiedKernel {
  template <typename Pack, typename Number>
  static PackImage<Pack> project(const Number* p, Number limit, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const ScaledPoint<Pack> at(point);
    const Number alpha = p[4], beta = p[5];
    const Pack square = at.x * at.x + at.y * at.y;
    const Pack d = square_root(beta * square + at.z * at.z);
    const Denominator<Pack> all = {alpha * d + (1.0 - alpha) * at.z, alpha * beta / d,
                                   alpha * (at.z / d) + (1.0 - alpha), d - at.z,
                                   0.5 * alpha * (square / d)};
    return all.image(p, at, -(limit * d) < at.z, jacobian);
  }
};

struct ParallelKernel {
  template <typename Pack, typename Number>
  static PackImage<Pack> project(const Number* p, Number, const PackPoint<Pack>& point,
                                 PackJacobian<Pack>* jacobian) {
    const Pack x = point.x + p[kOx] * point.z, y = point.y + p[kOy] * point.z;
    if (jacobian) {
      jacobian->set_focal_columns(x, y);
      for (int row = 0; row < 2; ++row) {
        for (int i = 0; i < 2; ++i) {
          jacobian->by_point[row][i] = row == i ? splat<Pack>(p[row]) : Pack{};
          jacobian->by_parameters[row][kOx + i] = row == i ? p[row] * point.z : Pack{};
        }
        jacobian->by_point[row][2] = splat<Pack>(p[row] * p[kOx + row]);
      }
    }
    // Zero times what is not finite is NaN.
    const Mask<Pack> valid = 0.0 * point.x + 0.0 * point.y + 0.0 * point.z == 0.0;
    return {p[kFx] * x + p[kCx], p[kFy] * y + p[kCy], valid};
  }
};

// Calls of<Kernel>(kind) for each kernel.
template <typename Of>
constexpr void for_each_kernel(const Of& of) {
  of.template operator()<PerspectiveKernel<kPinhole>>(kPinhole);
  of.template operator()<PerspectiveKernel<kBrownConrady>>(kBrownConrady);
  of.template operator()<PerspectiveKernel<kRational>>(kRational);
  of.template operator()<FisheyeKernel>(kFisheye);
  of.template operator()<ParallelKernel>(kParallel);
  of.template operator()<DoubleSphereKernel>(kDoubleSphere);
  of.template operator()<ExtendedUnifiedKernel>(kExtendedUnified);
}

}  // namespace
}  // namespace tagcal::internal
