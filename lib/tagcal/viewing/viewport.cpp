#include "tagcal/viewing/viewport.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal {
namespace {

// The first parameters of every lens are two scales and the principal point; distortion does not
// depend on the pixels.
template <typename L>
Lens with_scale_and_centre(const L& lens, const Eigen::Vector2d& scale,
                           const Eigen::Vector2d& centre) {
  typename L::Parameters p = lens.parameters();
  p[0] = scale.x();
  p[1] = scale.y();
  p[2] = centre.x();
  p[3] = centre.y();
  return L(p);
}

// The camera whose pixels are u' = s (u + 1/2) - 1/2 - shift.
Camera on_other_pixels(const Camera& camera, const Eigen::Vector2d& s, const Eigen::Vector2d& shift,
                       const ImageSize& size) {
  if (size.width < 1 || size.height < 1)
    throw Error(
        fmt::format("camera: the image must have pixels, got {}x{}", size.width, size.height));
  const auto p = parameters(camera.lens);
  const Eigen::Vector2d half(0.5, 0.5), focal(p[0], p[1]), centre(p[2], p[3]);
  const Eigen::Vector2d new_centre = s.cwiseProduct(centre + half) - half - shift;
  return {std::visit(
              [&](const auto& l) {
                return with_scale_and_centre(l, s.cwiseProduct(focal), new_centre);
              },
              camera.lens),
          size};
}

}  // namespace

Eigen::Matrix3d viewport_from_window(const Window& viewport, const Window& window) {
  if (!(window.left < window.right) || !(window.bottom < window.top))
    throw Error("viewport: the window must have an area");
  const double sx = (viewport.right - viewport.left) / (window.right - window.left);
  const double sy = (viewport.top - viewport.bottom) / (window.top - window.bottom);
  Eigen::Matrix3d matrix;
  matrix << sx, 0, viewport.left - sx * window.left,  //
      0, sy, viewport.bottom - sy * window.bottom,    //
      0, 0, 1;
  return matrix;
}

Eigen::Matrix4d raster_from_ndc(const Raster& raster) {
  const double w = raster.size.width, h = raster.size.height;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = w / 2;
  matrix(1, 1) = (raster.y_down ? -1 : 1) * h / 2;
  matrix(0, 3) = (w - 1) / 2 + raster.offset_px.x();
  matrix(1, 3) = (h - 1) / 2 + raster.offset_px.y();
  if (raster.num_depths > 0) {
    matrix(2, 2) = raster.num_depths / 2.0;
    matrix(2, 3) = (raster.num_depths - 1) / 2.0;
  }
  return matrix;
}

std::vector<PixelRectangle> sectors(const ImageSize& size, int columns, int rows) {
  if (columns < 1 || rows < 1 || columns > size.width || rows > size.height)
    throw Error(fmt::format("sectors: must be 1x1 to {}x{}, got {}x{}", size.width, size.height,
                            columns, rows));
  // The border before part i of n; in 64 bits, since the product may be large.
  const auto border = [](int extent, int i, int n) {
    return static_cast<int>(static_cast<long long>(extent) * i / n);
  };
  std::vector<PixelRectangle> result;
  for (int row = 0; row < rows; ++row) {
    const int y = border(size.height, row, rows);
    const int height = border(size.height, row + 1, rows) - y;
    for (int column = 0; column < columns; ++column) {
      const int x = border(size.width, column, columns);
      result.push_back({x, y, {border(size.width, column + 1, columns) - x, height}});
    }
  }
  return result;
}

Camera cropped(const Camera& camera, const PixelRectangle& part) {
  return on_other_pixels(camera, {1, 1}, {part.x, part.y}, part.size);
}

Camera binned(const Camera& camera, int columns, int rows) {
  if (columns < 1 || rows < 1)
    throw Error(fmt::format("binning: must be 1x1 at least, got {}x{}", columns, rows));
  return on_other_pixels(camera, {1.0 / columns, 1.0 / rows}, {0, 0},
                         {camera.image_size.width / columns, camera.image_size.height / rows});
}

Camera resized(const Camera& camera, const ImageSize& size) {
  const double across = static_cast<double>(size.width) / camera.image_size.width;
  const double down = static_cast<double>(size.height) / camera.image_size.height;
  return on_other_pixels(camera, {across, down}, {0, 0}, size);
}

Camera undistorted(const Camera& camera) {
  const auto p = parameters(camera.lens);
  if (!kind_of(camera.lens).is_central)
    return {Parallel({p[0], p[1], p[2], p[3]}), camera.image_size};
  const Eigen::Vector2d focal = focal_lengths_px(camera.lens);
  return {pinhole(focal.x(), focal.y(), p[2], p[3]), camera.image_size};
}

CameraBehindWindow camera_behind(const WindowInWorld& window, const Eigen::Vector3d& eye,
                                 const ImageSize& size) {
  using Eigen::Vector3d;
  const Vector3d across = window.lower_right - window.lower_left;
  const Vector3d up = window.upper_left - window.lower_left;
  const double width_m = across.norm(), height_m = up.norm();
  if (!(std::abs(across.dot(up)) <= 1e-9 * width_m * height_m) || !(width_m * height_m > 0))
    throw Error("window: must be a rectangle with an area");
  Eigen::Matrix3d axes;
  axes << across / width_m, -up / height_m, up.cross(across) / (width_m * height_m);
  const Vector3d corner = axes.transpose() * (window.upper_left - eye);  // in the camera
  if (!(corner.z() > 0)) throw Error("window: the eye must be before it");
  const double per_x = size.width / width_m, per_y = size.height / height_m;  // pixels per metre
  return {{pinhole(corner.z() * per_x, corner.z() * per_y, -corner.x() * per_x - 0.5,
                   -corner.y() * per_y - 0.5),
           size},
          camera_from_world_with_axes(axes, eye)};
}

}  // namespace tagcal
