#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "tagcal/geometry/pose.hpp"

// A lens projects a point in the camera frame (x right, y down, z forward; metres) to a pixel
// ((0, 0) is the centre of the top-left pixel). Every lens has the same interface:
//
//   kNumParameters, kParameterNames         its parameters in OpenCV's order
//   Lens(parameters)                        throws Error unless all are finite and the scales > 0
//   project(x)                              the pixel, or no value outside the domain
//   project(x, by_point, by_parameters)     the same with analytic Jacobians (either may be null)
//   ray_in_camera(pixel)                    the inverse, or no value where no point projects there
//   in_domain(x)                            true if project has a value
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

// Pinhole with Brown-Conrady distortion, polynomial or rational (Brown 1971; OpenCV calib3d), with
// (x, y) = (X/Z, Y/Z), s = x^2 + y^2:
//   L  = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3)
//   x' = x L + 2 p1 x y + p2 (s + 2 x^2)       u = fx x' + cx
//   y' = y L + p1 (s + 2 y^2) + 2 p2 x y       v = fy y' + cy
// Domain: Z > 0 and r = sqrt(s) < max_radius(). Within this radius the Jacobian of the distortion
// is positive definite; on a disc the distortion is then one-to-one. Without tangential terms the
// radius is the fold itself: the smallest r with d(r L)/dr = 0 or a pole of L.
class Perspective {
 public:
  static constexpr int kNumParameters = 12;
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {
      "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  using Parameters = std::array<double, kNumParameters>;
  using ParameterJacobian = Eigen::Matrix<double, 2, kNumParameters>;

  explicit Perspective(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }
  double max_radius() const { return max_radius_; }  // of (X/Z, Y/Z); infinite without a fold

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera,
                                         PointJacobian* by_point,
                                         ParameterJacobian* by_parameters) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
  double max_radius_;
};

// Equidistant fisheye with an odd polynomial (Kannala & Brandt, PAMI 2006; cv::fisheye), with
// theta = atan2(sqrt(X^2 + Y^2), Z), the angle from the optical axis:
//   theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//   (u, v) = (fx, fy) theta_d (X, Y) / sqrt(X^2 + Y^2) + (cx, cy)
// Domain: theta < max_angle(), which is at most pi and at most the fold d(theta_d)/d(theta) = 0.
// The domain includes points beside and behind the camera (Z <= 0) up to that angle.
class Fisheye {
 public:
  static constexpr int kNumParameters = 8;
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {
      "fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
  using Parameters = std::array<double, kNumParameters>;
  using ParameterJacobian = Eigen::Matrix<double, 2, kNumParameters>;

  explicit Fisheye(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }
  double max_angle() const { return max_angle_; }  // radians

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera,
                                         PointJacobian* by_point,
                                         ParameterJacobian* by_parameters) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
  double max_angle_;
};

// Parallel projection onto the plane Z = 0, with the scales in pixels per metre:
//   u = sx (X + ox Z) + cx       v = sy (Y + oy Z) + cy
// Orthographic (weak perspective) at ox = oy = 0. Otherwise oblique: depth recedes in the picture
// by (ox, oy), metres per metre. Every point is in its domain; its rays start in the plane Z = 0
// and run along (-ox, -oy, 1).
class Parallel {
 public:
  static constexpr int kNumParameters = 6;
  static constexpr std::array<std::string_view, kNumParameters> kParameterNames = {
      "sx", "sy", "cx", "cy", "ox", "oy"};
  using Parameters = std::array<double, kNumParameters>;
  using ParameterJacobian = Eigen::Matrix<double, 2, kNumParameters>;

  explicit Parallel(const Parameters& parameters);

  const Parameters& parameters() const { return p_; }
  bool oblique() const { return p_[4] != 0 || p_[5] != 0; }

  bool in_domain(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera) const;
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& x_in_camera,
                                         PointJacobian* by_point,
                                         ParameterJacobian* by_parameters) const;
  std::optional<Ray> ray_in_camera(const Eigen::Vector2d& pixel) const;

 private:
  Parameters p_;
};

using Lens = std::variant<Perspective, Fisheye, Parallel>;

// A pinhole without distortion.
Perspective pinhole(double fx, double fy, double cx, double cy);

// The interface above for any lens, which must outlive its parameters.
std::span<const double> parameters(const Lens& lens);
std::span<const double> parameters(const Lens&& lens) = delete;
std::span<const std::string_view> parameter_names(const Lens& lens);
bool in_domain(const Lens& lens, const Eigen::Vector3d& x_in_camera);
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
