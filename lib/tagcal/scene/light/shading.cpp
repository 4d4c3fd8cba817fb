#include "tagcal/scene/light/shading.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double cos4_factor(const Lens& lens, const Vector2d& pixel) {
  const std::optional<Ray> ray = ray_in_camera(lens, pixel);
  if (!ray || !(ray->direction.z() > 0))
    throw Error(
        fmt::format("vignetting: cos4 needs rays below 90 degrees to the optical axis, "
                    "which pixel ({:.0f}, {:.0f}) has not",
                    pixel.x(), pixel.y()));
  return std::pow(ray->direction.z(), 4);
}

double polynomial_factor(const std::vector<double>& coefficients, const ImageSize& size,
                         const Vector2d& pixel) {
  const double half_diagonal = 0.5 * std::hypot(size.width, size.height);
  const double r2 = ((pixel - image_centre(size)) / half_diagonal).squaredNorm();
  double factor = 0;
  for (auto a = coefficients.rbegin(); a != coefficients.rend(); ++a) factor = (factor + *a) * r2;
  ++factor;
  if (!(factor >= 0))
    throw Error(
        fmt::format("vignetting: must not be negative in the image, got {:.3g} at pixel "
                    "({:.0f}, {:.0f})",
                    factor, pixel.x(), pixel.y()));
  return factor;
}

}  // namespace

Light in_frame(const Pose& target_from_source, Light light) {
  if (auto* sun = std::get_if<DirectionalLamp>(&light.lamp))
    sun->direction = target_from_source.rotation() * sun->direction;
  if (auto* point = std::get_if<PointLamp>(&light.lamp))
    point->position = target_from_source * point->position;
  return light;
}

std::optional<Light> light_in_camera(const Scene& scene, const Pose& camera_from_world) {
  if (!scene.light || scene.light->on_camera) return scene.light;
  return in_frame(camera_from_world, *scene.light);
}

Shading::Shading(const Light& light, const Vector3d& normal, const Vector3d& x)
    : uniform_(light.ambient), normal_(normal), offset_(normal.dot(x)) {
  if (const auto* sun = std::get_if<DirectionalLamp>(&light.lamp))
    uniform_ += sun->strength * std::max(0.0, -normal.dot(sun->direction.normalized()));
  if (const auto* point = std::get_if<PointLamp>(&light.lamp)) {
    lamp_ = point->position;
    point_gain_ = point->strength * std::max(0.0, normal.dot(lamp_) - offset_);
  }
}

double Shading::at(const Vector3d& x_on_sheet) const {
  if (is_uniform()) return uniform_;
  const double r2 = (lamp_ - x_on_sheet).squaredNorm();
  return uniform_ + point_gain_ / (r2 * std::sqrt(r2));
}

double Shading::at(const Ray& ray) const {
  const double along = (offset_ - normal_.dot(ray.origin)) / normal_.dot(ray.direction);
  if (!std::isfinite(along) || (along <= 0 && ray.origin.isZero(0))) return uniform_;
  return at(ray.origin + along * ray.direction);
}

void vignette(const Camera& camera, const Vignetting& vignetting, ImageF& light) {
  if (!vignetting.cos4 && vignetting.polynomial.empty()) return;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const Vector2d pixel(x, y);
      double factor = polynomial_factor(vignetting.polynomial, light.size(), pixel);
      if (vignetting.cos4) factor *= cos4_factor(camera.lens, pixel);
      light(x, y) *= static_cast<float>(factor);
    }
}

// The angle to the axis is largest at a corner.
void check_vignetting(const Camera& camera, const Vignetting& vignetting) {
  const ImageSize& size = camera.image_size;
  if (!vignetting.polynomial.empty())
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        polynomial_factor(vignetting.polynomial, size, Vector2d(x, y));
  if (!vignetting.cos4) return;
  for (const int x : {0, size.width - 1})
    for (const int y : {0, size.height - 1}) cos4_factor(camera.lens, Vector2d(x, y));
}

}  // namespace tagcal::internal
