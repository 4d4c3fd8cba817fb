#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "tagcal/camera/camera.hpp"

// Wide-angle lens models that other tools write and tagcal does not estimate. They are sources: a
// program reads them from a file, and fit_lens (estimate/lens_fit.hpp) finds the lens of tagcal
// that projects alike. Their interface is that of lens.hpp without Jacobians; points, pixels and
// rays mean the same. All are central, so every ray starts at the origin of the camera frame.

namespace tagcal {

// Double sphere (Usenko, Demmel & Cremers, The Double Sphere Camera Model, 3DV 2018), as Basalt and
// Kalibr (`ds`) write it. With d1 = |(X, Y, Z)| and d2 = |(X, Y, xi d1 + Z)|:
//   (u, v) = (fx X, fy Y) / (alpha d2 + (1 - alpha) (xi d1 + Z)) + (cx, cy)
// Parameters: fx, fy > 0; -1 < xi < 1; 0 <= alpha <= 1.
// Domain: xi d1 + Z > -w d2 with w = min(alpha, 1 - alpha) / max(alpha, 1 - alpha), which ends
// where the denominator vanishes (alpha <= 1/2) or the radius in the image turns back (alpha >
// 1/2). The bound of the paper, Z > -w2 d1, is another one: narrower for some parameters, and for
// others (alpha = 1, xi < 0) it admits points beyond the turn.
class DoubleSphere {
 public:
  static constexpr int kNumParameters = 6;
  static constexpr std::string_view kName = "double sphere";
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {
      "fx", "fy", "cx", "cy", "xi", "alpha"};
  using Parameters = std::array<double, kNumParameters>;

  explicit DoubleSphere(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
};

// Extended unified model, EUCM (Khomutenko, Garcia & Martinet, An Enhanced Unified Camera Model,
// RA-L 2016), `eucm` in Basalt and Kalibr. With d = sqrt(beta (X^2 + Y^2) + Z^2):
//   (u, v) = (fx X, fy Y) / (alpha d + (1 - alpha) Z) + (cx, cy)
// Parameters: fx, fy, beta > 0; 0 <= alpha <= 1.
// Domain: Z > -w d with w = min(alpha, 1 - alpha) / max(alpha, 1 - alpha).
class ExtendedUnified {
 public:
  static constexpr int kNumParameters = 6;
  static constexpr std::string_view kName = "extended unified";
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {
      "fx", "fy", "cx", "cy", "alpha", "beta"};
  using Parameters = std::array<double, kNumParameters>;

  explicit ExtendedUnified(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
};

// Unified model, UCM, in Basalt's form (`ucm`): the extended one with beta = 1. With
// d = |(X, Y, Z)|:
//   (u, v) = (fx X, fy Y) / (alpha d + (1 - alpha) Z) + (cx, cy)
// Parameters: fx, fy > 0; 0 <= alpha <= 1. Domain as of the extended one.
class Unified {
 public:
  static constexpr int kNumParameters = 5;
  static constexpr std::string_view kName = "unified";
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {"fx", "fy", "cx",
                                                                                   "cy", "alpha"};
  using Parameters = std::array<double, kNumParameters>;

  explicit Unified(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
};

// The same lens as Kalibr's `omni` model without distortion (Mei & Rives, ICRA 2007), which is
//   (u, v) = (fu X, fv Y) / (Z + xi d) + (pu, pv)
// exactly: alpha = xi / (1 + xi), fx = fu / (1 + xi), fy = fv / (1 + xi). Throws Error
// unless xi >= 0. With distortion behind it (`radtan`, or OpenCV's omnidir) no unified model is the
// same lens.
Unified unified_from_omni(double xi, double fu, double fv, double pu, double pv);

using ForeignLens = std::variant<DoubleSphere, ExtendedUnified, Unified>;

// The interface above for any of them.
std::string_view lens_name(const ForeignLens& lens);
std::span<const double> parameters(const ForeignLens& lens);
std::span<const std::string_view> parameter_names(const ForeignLens& lens);
bool in_domain(const ForeignLens& lens, const Eigen::Vector3d& x_in_camera);
std::optional<Eigen::Vector2d> project(const ForeignLens& lens, const Eigen::Vector3d& x_in_camera);
std::optional<Ray> ray_in_camera(const ForeignLens& lens, const Eigen::Vector2d& pixel);

// A lens that a file may hold: one of tagcal's, or a source for a fit. `std::visit` with project,
// parameters, .. serves both.
using SourceLens = std::variant<Lens, ForeignLens>;

// A lens of a file and the size of the image behind it.
struct SourceCamera {
  SourceLens lens = pinhole(1, 1, 0, 0);
  ImageSize image_size;
};

}  // namespace tagcal
