#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "tagcal/geometry/pose.hpp"

// A lens projects a point in the camera frame (x right, y down, z forward; metres) to a pixel
// ((0, 0) is the centre of the top-left pixel). Every lens has the same interface:
//
//   kParameters                             its parameters as data, in OpenCV's order
//   Lens(parameters)                        throws Error unless all are finite and in their ranges
//   project(x)                              the pixel, or no value outside the domain
//   project(x, by_point, by_parameters)     the same with analytic Jacobians (either may be null)
//   ray_in_camera(pixel)                    the inverse, or no value where no point projects there
//   in_domain(x)                            true if project has a value
//   max_angle()                             the domain's, from the axis, radians (a lens of rays
//                                           from one centre)
//
// Each kind is one class here, one file in lenses/ and one kernel in kernels/, which has the
// formulas. What algorithms ask about a kind is data: LensKind.
//
// The domain is the set of points on which the model is one-to-one. `project` tests it before it
// projects, because the image of a point behind the camera, or beyond the fold of the distortion,
// looks like any other pixel.

namespace tagcal {

// The points `origin + s * direction`, in the camera frame; direction is a unit vector.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

using PointJacobian = Eigen::Matrix<double, 2, 3>;

// The role of a parameter. A `radial` coefficient multiplies a power of the squared radius and
// vanishes without distortion; a `shape` parameter describes the curve from angle to radius itself.
enum class ParameterRole { focal_length, principal_point, radial, tangential, shape };

struct LensParameter {
  std::string_view name;
  ParameterRole role = ParameterRole::radial;
  // The power of the squared radius that a radial coefficient multiplies, negative in a
  // denominator; 0 for other roles.
  int power = 0;
  // The standard deviation before any picture: of a distortion coefficient, the share of its radius
  // by which it moves the corner of the image; of a shape, that of the parameter about `plain`. The
  // policy of `estimate` has those of the scales and the principal point.
  double prior_sigma = 0;
  // The value without distortion, or that of a usual lens of this shape, for a focal length of 1 on
  // the axis at the pixel (0, 0).
  double plain = 0;
  // The range; with its ends, or without.
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool has_ends = false;

  bool holds(double value) const {
    return (least < value && value < most) || (has_ends && (value == least || value == most));
  }
};

// The scales along x and y and the principal point of every lens, before its other parameters.
template <std::size_t N>
constexpr std::array<LensParameter, N + 4> with_scales(std::string_view sx, std::string_view sy,
                                                       const std::array<LensParameter, N>& more,
                                                       double plain_scale = 1) {
  using enum ParameterRole;
  std::array<LensParameter, N + 4> all = {{{sx, focal_length, 0, 0, plain_scale, 0},
                                           {sy, focal_length, 0, 0, plain_scale, 0},
                                           {"cx", principal_point},
                                           {"cy", principal_point}}};
  for (std::size_t i = 0; i < N; ++i) all[i + 4] = more[i];
  return all;
}

// The members that all lens classes share. `Self` is the class; it has N parameters.
template <typename Self, int N>
class LensOf {
 public:
  static constexpr int kNumParameters = N;
  using Parameters = std::array<double, N>;
  using ParameterJacobian = Eigen::Matrix<double, 2, N>;

  const Parameters& parameters() const { return p_; }
  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera,
                                         PointJacobian* by_point,
                                         ParameterJacobian* by_parameters) const;

 protected:
  explicit LensOf(const Parameters& parameters);

  Parameters p_;
};

// Pinhole with Brown-Conrady distortion, polynomial or rational (Brown 1971; OpenCV calib3d), with
// (x, y) = (X/Z, Y/Z), s = x^2 + y^2:
//   L  = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3)
//   x' = x L + 2 p1 x y + p2 (s + 2 x^2)       u = fx x' + cx
//   y' = y L + p1 (s + 2 y^2) + 2 p2 x y       v = fy y' + cy
// Domain: Z > 0 and r = sqrt(s) < max_radius(). Within this radius the Jacobian of the distortion
// is positive definite; on a disc the distortion is then one-to-one. Without tangential terms the
// radius is the fold itself: the smallest r with d(r L)/dr = 0 or a pole of L.
class Perspective : public LensOf<Perspective, 12> {
 public:
  static constexpr std::string_view kName = "perspective";
  static constexpr bool kIsCentral = true, kReachesBehind = false;
  // The 1,133 lenses of liblensfun-data-v1 have k1 and k2 of 7 and 4 % (RMS) of the radius below 35
  // degrees of half diagonal, 13 and up to 14 % beyond: these priors are wider. Numerator and
  // denominator have the same.
  static constexpr auto kParameters =
      with_scales("fx", "fy",
                  std::array<LensParameter, 8>{{{"k1", ParameterRole::radial, 1, 0.20},
                                                {"k2", ParameterRole::radial, 2, 0.10},
                                                {"p1", ParameterRole::tangential, 0, 0.005},
                                                {"p2", ParameterRole::tangential, 0, 0.005},
                                                {"k3", ParameterRole::radial, 3, 0.05},
                                                {"k4", ParameterRole::radial, -1, 0.20},
                                                {"k5", ParameterRole::radial, -2, 0.10},
                                                {"k6", ParameterRole::radial, -3, 0.05}}});

  explicit Perspective(const Parameters& parameters);
  double max_radius() const { return max_radius_; }  // of (X/Z, Y/Z); infinite without a fold
  double max_angle() const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  double max_radius_;
};

// Equidistant fisheye with an odd polynomial (Kannala & Brandt, PAMI 2006; cv::fisheye), with
// theta = atan2(sqrt(X^2 + Y^2), Z), the angle from the optical axis:
//   theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//   (u, v) = (fx, fy) theta_d (X, Y) / sqrt(X^2 + Y^2) + (cx, cy)
// Domain: theta < max_angle(), which is at most pi and at most the fold d(theta_d)/d(theta) = 0.
// The domain includes points beside and behind the camera (Z <= 0) up to that angle.
class Fisheye : public LensOf<Fisheye, 8> {
 public:
  static constexpr std::string_view kName = "fisheye";
  static constexpr bool kIsCentral = true, kReachesBehind = true;
  static constexpr auto kParameters =
      with_scales("fx", "fy",
                  std::array<LensParameter, 4>{{{"k1", ParameterRole::radial, 1, 0.15},
                                                {"k2", ParameterRole::radial, 2, 0.08},
                                                {"k3", ParameterRole::radial, 3, 0.04},
                                                {"k4", ParameterRole::radial, 4, 0.02}}});

  explicit Fisheye(const Parameters& parameters);
  double max_angle() const { return max_angle_; }
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  double max_angle_;
};

// Parallel projection onto the plane Z = 0, with the scales in pixels per metre:
//   u = sx (X + ox Z) + cx       v = sy (Y + oy Z) + cy
// Orthographic (weak perspective) at ox = oy = 0. Otherwise oblique: depth recedes in the picture
// by (ox, oy), metres per metre. Every point is in its domain; its rays start in the plane Z = 0
// and run along (-ox, -oy, 1).
class Parallel : public LensOf<Parallel, 6> {
 public:
  static constexpr std::string_view kName = "parallel";
  static constexpr bool kIsCentral = false, kReachesBehind = false;
  static constexpr auto kParameters = with_scales(
      "sx", "sy",
      std::array<LensParameter, 2>{{{"ox", ParameterRole::shape}, {"oy", ParameterRole::shape}}});

  explicit Parallel(const Parameters& parameters) : LensOf(parameters) {}
  bool oblique() const { return p_[4] != 0 || p_[5] != 0; }
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;
};

// Double sphere (Usenko, Demmel & Cremers, The Double Sphere Camera Model, 3DV 2018), as Basalt and
// Kalibr (`ds`) write it. With d1 = |(X, Y, Z)| and d2 = |(X, Y, xi d1 + Z)|:
//   (u, v) = (fx X, fy Y) / (alpha d2 + (1 - alpha) (xi d1 + Z)) + (cx, cy)
// The focal length on the axis is fx / (1 + xi).
// Domain: xi d1 + Z > -w d2 with w = min(alpha, 1 - alpha) / max(alpha, 1 - alpha), which ends
// where the denominator vanishes (alpha <= 1/2) or the radius in the image turns back (alpha >
// 1/2). The bound of the paper, Z > -w2 d1, is another one: narrower for some parameters, and for
// others (alpha = 1, xi < 0) it admits points beyond the turn.
class DoubleSphere : public LensOf<DoubleSphere, 6> {
 public:
  static constexpr std::string_view kName = "double sphere";
  static constexpr bool kIsCentral = true, kReachesBehind = true;
  // Published calibrations of Kalibr's and Basalt's example sets (TUM-VI, EuRoC) have xi of -0.27
  // to -0.02, alpha of 0.54 to 0.6: these priors are wider.
  static constexpr auto kParameters = with_scales(
      "fx", "fy",
      std::array<LensParameter, 2>{{{"xi", ParameterRole::shape, 0, 0.3, -0.2, -1, 1},
                                    {"alpha", ParameterRole::shape, 0, 0.2, 0.6, 0, 1, true}}},
      0.8);

  explicit DoubleSphere(const Parameters& parameters) : LensOf(parameters) {}
  double max_angle() const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;
};

// Extended unified model, EUCM (Khomutenko, Garcia & Martinet, An Enhanced Unified Camera Model,
// RA-L 2016), `eucm` in Basalt and Kalibr. With d = sqrt(beta (X^2 + Y^2) + Z^2):
//   (u, v) = (fx X, fy Y) / (alpha d + (1 - alpha) Z) + (cx, cy)
// With beta = 1 it is the unified model, UCM, in Basalt's form.
// Domain: Z > -w d with w = min(alpha, 1 - alpha) / max(alpha, 1 - alpha).
class ExtendedUnified : public LensOf<ExtendedUnified, 6> {
 public:
  static constexpr std::string_view kName = "extended unified";
  static constexpr bool kIsCentral = true, kReachesBehind = true;
  // Basalt's published calibration of EuRoC has alpha 0.59 and beta 1.13: these priors are wider.
  static constexpr auto kParameters = with_scales(
      "fx", "fy",
      std::array<LensParameter, 2>{{{"alpha", ParameterRole::shape, 0, 0.2, 0.6, 0, 1, true},
                                    {"beta", ParameterRole::shape, 0, 0.5, 1, 0}}});

  explicit ExtendedUnified(const Parameters& parameters) : LensOf(parameters) {}
  double max_angle() const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;
};

// Kalibr's `omni` model without distortion (Mei & Rives, ICRA 2007), which is
//   (u, v) = (fu X, fv Y) / (Z + xi d) + (pu, pv)
// exactly: alpha = xi / (1 + xi), fx = fu / (1 + xi), fy = fv / (1 + xi), beta = 1. Throws Error
// unless xi >= 0. With distortion behind it (`radtan`, or OpenCV's omnidir) it is another lens.
ExtendedUnified unified_from_omni(double xi, double fu, double fv, double pu, double pv);

using Lens = std::variant<Perspective, Fisheye, Parallel, DoubleSphere, ExtendedUnified>;

// A kind of lens: what algorithms ask about it. There is one object a kind.
struct LensKind {
  std::string_view name;
  std::span<const LensParameter> parameters;
  std::span<const std::string_view> parameter_names;
  bool is_central = true;       // all rays start at the origin of the camera frame
  bool reaches_behind = false;  // sees beside and behind the camera (Z <= 0), given the parameters
  // The lens of these parameters; no value unless all are finite and in their ranges.
  std::optional<Lens> (*lens)(std::span<const double> parameters) = nullptr;
};

// All kinds, in the order of Lens' alternatives.
std::span<const LensKind> lens_kinds();
const LensKind& kind_of(const Lens& lens);

// The kind of an alternative of Lens.
template <typename L>
const LensKind& kind_of();

// The lens of these parameters. Throws Error unless all are finite and in their ranges.
// Precondition: as many as the kind has.
Lens make_lens(const LensKind& kind, std::span<const double> parameters);

// The lens of a kind with its plain values. Precondition: focal_px > 0.
Lens plain_lens(const LensKind& kind, double focal_px, const Eigen::Vector2d& centre);

// A pinhole without distortion.
Perspective pinhole(double fx, double fy, double cx, double cy);

// The interface above for any lens, which must outlive its parameters.
std::span<const double> parameters(const Lens& lens);
std::span<const double> parameters(const Lens&& lens) = delete;
std::span<const std::string_view> parameter_names(const Lens& lens);
bool in_domain(const Lens& lens, const Eigen::Vector3d& x_in_camera);
// The domain's largest angle from the axis, radians. Precondition: a central lens.
double max_angle(const Lens& lens);
// Focal lengths (fx, fy) on the axis, in pixels. Precondition: a central lens.
Eigen::Vector2d focal_lengths_px(const Lens& lens);
std::optional<Eigen::Vector2d> project(const Lens& lens, const Eigen::Vector3d& x_in_camera);
std::optional<Ray> ray_in_camera(const Lens& lens, const Eigen::Vector2d& pixel);

// Projects many points at once along the chain source -> camera -> image. valid[i] is 1 if point i
// is in the domain; otherwise pixels[i] is NaN. Returns the number of valid points. Throws Error
// unless the sizes are equal. Agrees with the functions above to rounding; batch.hpp adds
// Jacobians.
std::size_t project(const Lens& lens, const Pose& camera_from_source,
                    std::span<const Eigen::Vector3d> x_in_source, std::span<Eigen::Vector2d> pixels,
                    std::span<std::uint8_t> valid);

}  // namespace tagcal
