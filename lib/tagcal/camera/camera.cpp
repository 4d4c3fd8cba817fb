#include "tagcal/camera/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/camera/lenses/polynomial.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The angle between the rays through two pixels; of a lens that reaches behind, via the optical
// axis.
std::optional<double> angle_between_rad(const Lens& lens, const Eigen::Vector2d& a,
                                        const Eigen::Vector2d& b) {
  const std::optional<Ray> ray_a = ray_in_camera(lens, a), ray_b = ray_in_camera(lens, b);
  if (!ray_a || !ray_b) return std::nullopt;
  const auto angle = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return std::atan2(p.cross(q).norm(), p.dot(q));
  };
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  if (kind_of(lens).reaches_behind)
    return angle(ray_a->direction, axis) + angle(axis, ray_b->direction);
  return angle(ray_a->direction, ray_b->direction);
}

}  // namespace

bool contains(const ImageSize& size, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.x() < size.width - 0.5 && pixel.y() >= -0.5 &&
         pixel.y() < size.height - 0.5;
}

Eigen::Vector2d image_centre(const ImageSize& size) {
  return {(size.width - 1) / 2.0, (size.height - 1) / 2.0};
}

double focal_from_field_of_view_px(double field_of_view_rad, double extent_px) {
  assert(field_of_view_rad > 0 && field_of_view_rad < std::numbers::pi);
  return extent_px / (2 * std::tan(field_of_view_rad / 2));
}

double field_of_view_rad(double focal_px, double extent_px) {
  assert(focal_px > 0);
  return 2 * std::atan2(extent_px, 2 * focal_px);
}

double field_of_view_rad(double field_of_view_rad, double from_extent, double to_extent) {
  assert(field_of_view_rad > 0 && field_of_view_rad < std::numbers::pi);
  return 2 * std::atan(std::tan(field_of_view_rad / 2) * to_extent / from_extent);
}

std::optional<FieldOfView> field_of_view(const Camera& camera) {
  if (!kind_of(camera.lens).is_central) return std::nullopt;
  const Eigen::Vector2d c(parameters(camera.lens)[2], parameters(camera.lens)[3]);
  const double right = camera.image_size.width - 0.5, bottom = camera.image_size.height - 0.5;
  const auto across = angle_between_rad(camera.lens, {-0.5, c.y()}, {right, c.y()});
  const auto down = angle_between_rad(camera.lens, {c.x(), -0.5}, {c.x(), bottom});
  const auto diagonal = angle_between_rad(camera.lens, {-0.5, -0.5}, {right, bottom});
  if (!across || !down || !diagonal) return std::nullopt;
  return FieldOfView{*across, *down, *diagonal};
}

bool has_pole(const Camera& camera) {
  const auto* lens = std::get_if<Perspective>(&camera.lens);
  if (!lens) return false;
  const Perspective::Parameters& p = lens->parameters();
  Polynomial denominator = {1, 0, p[kK4], 0, p[kK5], 0, p[kK6]};
  while (denominator.back() == 0) denominator.pop_back();
  double radius = 0;
  for (const double u : {-0.5, camera.image_size.width - 0.5}) {
    for (const double v : {-0.5, camera.image_size.height - 0.5}) {
      radius = std::max(radius, std::hypot((u - p[kCx]) / p[kFx], (v - p[kCy]) / p[kFy]));
      const std::optional<Ray> ray = lens->ray_in_camera({u, v});
      if (ray) radius = std::max(radius, ray->direction.head<2>().norm() / ray->direction.z());
    }
  }
  return denominator.size() > 1 && std::isfinite(smallest_positive_root(denominator, radius));
}

}  // namespace tagcal
