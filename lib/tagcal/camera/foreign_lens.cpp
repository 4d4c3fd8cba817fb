#include "tagcal/camera/foreign_lens.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "tagcal/camera/lenses/lens_parameters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

void check_between(std::string_view name, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw Error("lens: " + std::string(name) + " must be from " + short_number(low) + " to " +
                short_number(high) + ", got " + short_number(value));
}

// The unified model between a point on the unit sphere about its centre and the normalised image:
//   (x, y) = (X, Y) / (alpha d + (1 - alpha) Z),  d = |(X, Y, Z)|
// At the angle phi from the axis the radius is sin(phi) / (alpha + (1 - alpha) cos(phi)), with the
// slope (alpha cos(phi) + 1 - alpha) / (alpha + (1 - alpha) cos(phi))^2. The slope vanishes at
// cos(phi) = -(1 - alpha) / alpha, the denominator at cos(phi) = -alpha / (1 - alpha).
struct Sphere {
  double alpha = 0;

  bool in_domain(double z, double d) const {
    const double w = std::min(alpha, 1 - alpha) / std::max(alpha, 1 - alpha);
    return z > -w * d;
  }

  double denominator(double z, double d) const { return alpha * d + (1 - alpha) * z; }

  // Z of the point (x, y, Z) that projects to (x, y), by the squared radius of (x, y). No value at
  // and beyond the radius of the fold, 1 / sqrt(2 alpha - 1).
  std::optional<double> depth(double radius_square) const {
    const double root = 1 - (2 * alpha - 1) * radius_square;
    if (!(root > 0)) return std::nullopt;
    return (1 - alpha * alpha * radius_square) / (alpha * std::sqrt(root) + 1 - alpha);
  }
};

template <typename L>
Vector2d normalised(const L& lens, const Vector2d& pixel) {
  const auto& p = lens.parameters();
  return {(pixel.x() - p[2]) / p[0], (pixel.y() - p[3]) / p[1]};
}

// The pixel of (X, Y) over a denominator; no value if it is not finite.
template <typename L>
std::optional<Vector2d> pixel_of(const L& lens, const Vector3d& x, double denominator) {
  const auto& p = lens.parameters();
  const Vector2d pixel(p[0] * (x.x() / denominator) + p[2], p[1] * (x.y() / denominator) + p[3]);
  if (!pixel.allFinite()) return std::nullopt;
  return pixel;
}

// Both unified models: the extended one is the plain one of (sqrt(beta) X, sqrt(beta) Y, Z).
double extended_distance(double beta, const Vector3d& x) {
  const double scale = std::sqrt(beta);
  return std::hypot(scale * x.x(), scale * x.y(), x.z());
}

std::optional<Ray> unified_ray(double alpha, double beta, const Vector2d& m) {
  if (!m.allFinite()) return std::nullopt;
  const std::optional<double> z = Sphere{alpha}.depth(beta * m.squaredNorm());
  if (!z) return std::nullopt;
  return Ray{Vector3d::Zero(), Vector3d(m.x(), m.y(), *z).normalized()};
}

bool in_unified_domain(double alpha, double beta, const Vector3d& x) {
  return x.allFinite() && Sphere{alpha}.in_domain(x.z(), extended_distance(beta, x));
}

}  // namespace

DoubleSphere::DoubleSphere(const Parameters& parameters) : p_(checked<DoubleSphere>(parameters)) {
  if (!(std::abs(p_[4]) < 1))
    throw Error("lens: xi must be between -1 and 1, got " + short_number(p_[4]));
  check_between("alpha", p_[5], 0, 1);
}

bool DoubleSphere::in_domain(const Vector3d& x_in_camera) const {
  const double z = p_[4] * x_in_camera.stableNorm() + x_in_camera.z();
  return x_in_camera.allFinite() &&
         Sphere{p_[5]}.in_domain(z, std::hypot(x_in_camera.x(), x_in_camera.y(), z));
}

std::optional<Vector2d> DoubleSphere::project(const Vector3d& x_in_camera) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const double z = p_[4] * x_in_camera.stableNorm() + x_in_camera.z();
  const double d2 = std::hypot(x_in_camera.x(), x_in_camera.y(), z);
  return pixel_of(*this, x_in_camera, Sphere{p_[5]}.denominator(z, d2));
}

std::optional<Ray> DoubleSphere::ray_in_camera(const Vector2d& pixel) const {
  const Vector2d m = normalised(*this, pixel);
  if (!m.allFinite()) return std::nullopt;
  const std::optional<double> z = Sphere{p_[5]}.depth(m.squaredNorm());
  if (!z) return std::nullopt;
  // The point t (x, y, z) - (0, 0, xi) of the first sphere: t > 0 is the larger root.
  const double xi = p_[4], r_square = m.squaredNorm();
  const double t = (*z * xi + std::sqrt(*z * *z + (1 - xi * xi) * r_square)) / (*z * *z + r_square);
  return Ray{Vector3d::Zero(), Vector3d(t * m.x(), t * m.y(), t * *z - xi).normalized()};
}

ExtendedUnified::ExtendedUnified(const Parameters& parameters)
    : p_(checked<ExtendedUnified>(parameters)) {
  check_between("alpha", p_[4], 0, 1);
  if (!(p_[5] > 0)) throw Error("lens: beta must be > 0, got " + short_number(p_[5]));
}

bool ExtendedUnified::in_domain(const Vector3d& x_in_camera) const {
  return in_unified_domain(p_[4], p_[5], x_in_camera);
}

std::optional<Vector2d> ExtendedUnified::project(const Vector3d& x_in_camera) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const double d = extended_distance(p_[5], x_in_camera);
  return pixel_of(*this, x_in_camera, Sphere{p_[4]}.denominator(x_in_camera.z(), d));
}

std::optional<Ray> ExtendedUnified::ray_in_camera(const Vector2d& pixel) const {
  return unified_ray(p_[4], p_[5], normalised(*this, pixel));
}

Unified::Unified(const Parameters& parameters) : p_(checked<Unified>(parameters)) {
  check_between("alpha", p_[4], 0, 1);
}

bool Unified::in_domain(const Vector3d& x_in_camera) const {
  return in_unified_domain(p_[4], 1, x_in_camera);
}

std::optional<Vector2d> Unified::project(const Vector3d& x_in_camera) const {
  if (!in_domain(x_in_camera)) return std::nullopt;
  const double d = x_in_camera.stableNorm();
  return pixel_of(*this, x_in_camera, Sphere{p_[4]}.denominator(x_in_camera.z(), d));
}

std::optional<Ray> Unified::ray_in_camera(const Vector2d& pixel) const {
  return unified_ray(p_[4], 1, normalised(*this, pixel));
}

Unified unified_from_omni(double xi, double fu, double fv, double pu, double pv) {
  if (!(xi >= 0 && std::isfinite(xi)))
    throw Error("lens: xi must be >= 0, got " + short_number(xi));
  return Unified({fu / (1 + xi), fv / (1 + xi), pu, pv, xi / (1 + xi)});
}

std::string_view lens_name(const ForeignLens& lens) {
  return std::visit([](const auto& l) { return l.kName; }, lens);
}

std::span<const double> parameters(const ForeignLens& lens) {
  return std::visit([](const auto& l) { return std::span<const double>(l.parameters()); }, lens);
}

std::span<const std::string_view> parameter_names(const ForeignLens& lens) {
  return std::visit(
      [](const auto& l) { return std::span<const std::string_view>(l.kParameterNames); }, lens);
}

bool in_domain(const ForeignLens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.in_domain(x_in_camera); }, lens);
}

std::optional<Vector2d> project(const ForeignLens& lens, const Vector3d& x_in_camera) {
  return std::visit([&](const auto& l) { return l.project(x_in_camera); }, lens);
}

std::optional<Ray> ray_in_camera(const ForeignLens& lens, const Vector2d& pixel) {
  return std::visit([&](const auto& l) { return l.ray_in_camera(pixel); }, lens);
}

}  // namespace tagcal
