#include "tagcal/reproject/rows/outline.hpp"

#include <algorithm>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Vector2d> border_pixels(const ImageSize& size) {
  std::vector<Vector2d> pixels;
  const double right = size.width - 0.5, bottom = size.height - 0.5;
  for (int u = 0; u < size.width; ++u) pixels.emplace_back(u - 0.5, -0.5);
  for (int v = 0; v < size.height; ++v) pixels.emplace_back(right, v - 0.5);
  for (int u = size.width; u > 0; --u) pixels.emplace_back(u - 0.5, bottom);
  for (int v = size.height; v > 0; --v) pixels.emplace_back(-0.5, v - 0.5);
  return pixels;
}

// A pixel of the picture that has a ray: the principal point, or where it is in the picture, the
// nearest to it.
Vector2d middle_of(const Camera& camera) {
  const auto p = parameters(camera.lens);
  return {std::clamp(p[2], -0.5, camera.image_size.width - 0.5),
          std::clamp(p[3], -0.5, camera.image_size.height - 0.5)};
}

// The last pixel with a ray between one that has a ray and one that has none, to 1e-9 px or so.
Vector3d last_ray(const Lens& lens, Vector2d inside, Vector2d outside) {
  Vector3d last = ray_in_camera(lens, inside)->direction;
  for (int i = 0; i < 45; ++i) {  // halvings
    const Vector2d middle = (inside + outside) / 2;
    const auto ray = ray_in_camera(lens, middle);
    (ray ? inside : outside) = middle;
    if (ray) last = ray->direction;
  }
  return last;
}

}  // namespace

std::vector<Vector3d> outline_rays(const Camera& camera) {
  if (!kind_of(camera.lens).is_central)
    throw Error("reproject: a parallel lens has no rays from one centre");
  const Vector2d middle = middle_of(camera);
  if (camera.image_size.width <= 0 || camera.image_size.height <= 0 ||
      !ray_in_camera(camera.lens, middle))
    throw Error("reproject: the middle of the camera's picture has no ray");
  std::vector<Vector3d> rays;
  for (const Vector2d& pixel : border_pixels(camera.image_size))
    rays.push_back(ray_or_last(camera, pixel));
  return rays;
}

Vector3d ray_or_last(const Camera& camera, const Vector2d& pixel) {
  const auto ray = ray_in_camera(camera.lens, pixel);
  return ray ? ray->direction : last_ray(camera.lens, middle_of(camera), pixel);
}

std::vector<Vector3d> grid_rays(const Camera& camera) {
  constexpr int kSteps =
      64;  // numeric: the range of angles is smooth, 1/64 of the picture is enough
  std::vector<Vector3d> rays;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const Vector2d pixel(-0.5 + i * static_cast<double>(camera.image_size.width) / kSteps,
                           -0.5 + j * static_cast<double>(camera.image_size.height) / kSteps);
      if (const auto ray = ray_in_camera(camera.lens, pixel)) rays.push_back(ray->direction);
    }
  }
  return rays;
}

}  // namespace tagcal::internal
