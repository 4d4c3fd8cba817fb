#include "tagcal/reproject/cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/outline.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

double angle_from_axis(const Vector3d& ray) { return std::atan2(ray.head<2>().norm(), ray.z()); }

Error too_wide(double angle_rad, const char* what) {
  const auto text = [](double angle) { return with_decimals(degrees(angle), 0); };
  return Error(
      std::string(what) + " reaches " + text(angle_rad) +
      " degrees from the optical axis; a pinhole shows up to " + text(policy::kWidestAngle) +
      ": take a given focal length (the rest is cut off), a panorama, or several pinholes");
}

double aspect_of(const Camera& camera) {
  const auto p = parameters(camera.lens);
  return p[1] / p[0];
}

void check_size(const ImageSize& size) {
  if (size.width <= 0 || size.height <= 0)
    throw Error("reproject: the new picture must have pixels, got " + std::to_string(size.width) +
                "x" + std::to_string(size.height));
}

// The pinhole whose picture has the normalised point `middle` in its middle.
Camera pinhole_about(const Vector2d& middle, double fx, double fy, const ImageSize& size) {
  const Vector2d centre = image_centre(size);
  return {pinhole(fx, fy, centre.x() - fx * middle.x(), centre.y() - fy * middle.y()), size};
}

// Half the width of the largest rectangle of a shape (height / width) about a point of the
// normalised plane that does not cross the outline; negative where the point is outside of it.
class InnerRectangle {
 public:
  InnerRectangle(std::vector<Vector2d> outline, double shape)
      : outline_(std::move(outline)), shape_(shape) {
    for (Vector2d& point : outline_) point.y() /= shape_;  // now a square
  }

  // The place of the largest, found by a pattern search from the optical axis, and its half-width.
  std::pair<Vector2d, double> largest() const {
    Vector2d best = Vector2d::Zero();
    double most = half_width(best);
    for (double step = extent() / 4; step > 1e-9 * extent();) {
      Vector2d next = best;
      for (const Vector2d& way : kWays) {
        const double here = half_width(best + step * way);
        if (here > most) {
          most = here;
          next = best + step * way;
        }
      }
      if (next == best) step /= 2;
      best = next;
    }
    return {{best.x(), best.y() * shape_}, most};
  }

 private:
  static inline const std::array<Vector2d, 8> kWays = {Vector2d{1, 0}, {-1, 0}, {0, 1},  {0, -1},
                                                       {1, 1},         {1, -1}, {-1, 1}, {-1, -1}};

  double extent() const {
    double most = 0;
    for (const Vector2d& point : outline_) most = std::max(most, point.lpNorm<Eigen::Infinity>());
    return most;
  }

  // The distance (the larger of both axes) from a point to a side of the outline: the sides are
  // short, so that their ends and the places where both axes are equal tell it.
  static double distance(const Vector2d& a, const Vector2d& b) {
    double nearest = std::min(a.lpNorm<Eigen::Infinity>(), b.lpNorm<Eigen::Infinity>());
    const Vector2d way = b - a;
    const std::array<double, 2> numerators = {a.x() - a.y(), a.x() + a.y()};
    const std::array<double, 2> slopes = {way.y() - way.x(), -way.x() - way.y()};
    for (int i = 0; i < 2; ++i) {
      const double t = slopes[i] == 0 ? -1 : numerators[i] / slopes[i];
      if (t > 0 && t < 1) nearest = std::min(nearest, (a + t * way).lpNorm<Eigen::Infinity>());
    }
    return nearest;
  }

  double half_width(const Vector2d& point) const {
    double nearest = std::numeric_limits<double>::infinity();
    bool inside = false;  // a ray from the point crosses the outline an odd number of times
    for (std::size_t i = 0; i < outline_.size(); ++i) {
      const Vector2d a = outline_[i] - point, b = outline_[(i + 1) % outline_.size()] - point;
      nearest = std::min(nearest, distance(a, b));
      if ((a.y() > 0) != (b.y() > 0) && a.x() + (b.x() - a.x()) * a.y() / (a.y() - b.y()) > 0)
        inside = !inside;
    }
    return inside ? nearest : -nearest;
  }

  std::vector<Vector2d> outline_;
  double shape_;
};

// A camera about the vertical axis, turned to the right.
TurnedCamera turned(std::string name, const Camera& camera, double right_rad, double up_rad) {
  return {std::move(name), camera, rotation_about_y(right_rad) * rotation_about_x(up_rad)};
}

std::vector<TurnedCamera> cube_faces(double focal_px, int count) {
  const int side = std::max(1, static_cast<int>(std::ceil(2 * focal_px)));
  const ImageSize size{side, side};
  const Camera face = pinhole_about(Vector2d::Zero(), side / 2.0, side / 2.0, size);
  std::vector<TurnedCamera> faces = {turned("front", face, 0, 0), turned("left", face, -pi / 2, 0),
                                     turned("right", face, pi / 2, 0),
                                     turned("up", face, 0, pi / 2),
                                     turned("down", face, 0, -pi / 2)};
  if (count == 6) faces.push_back(turned("back", face, pi, 0));
  return faces;
}

std::vector<TurnedCamera> fan(const AngularRange& range, double focal_px, double fy, int count) {
  const double width_rad = (range.right_rad - range.left_rad) / count;
  constexpr double kWidest = 120 * pi / 180;  // numeric: stated in cameras.hpp
  if (width_rad > kWidest) {
    throw Error("a fan of " + std::to_string(count) + " pinholes would be " +
                std::to_string(std::lround(degrees(width_rad))) +
                " degrees wide each, 120 at most: take more, or 5 or 6 (a cube)");
  }
  const double limit = policy::kFanHeight / 2;
  const double top = std::tan(std::max(range.top_rad, -limit));
  const double bottom = std::tan(std::min(range.bottom_rad, limit));
  const ImageSize size{
      std::max(1, static_cast<int>(std::ceil(2 * focal_px * std::tan(width_rad / 2)))),
      std::max(1, static_cast<int>(std::ceil(fy * (bottom - top))))};
  const Camera camera = pinhole_about({0, (top + bottom) / 2}, focal_px, fy, size);
  std::vector<TurnedCamera> cameras;
  for (int i = 0; i < count; ++i)
    cameras.push_back(
        turned(std::to_string(i + 1), camera, range.left_rad + (i + 0.5) * width_rad, 0));
  return cameras;
}

}  // namespace

Camera pinhole_of_all_pixels(const Camera& camera, const ImageSize& size) {
  check_size(size);
  Eigen::AlignedBox2d box;
  double widest = 0;
  for (const Vector3d& ray : outline_rays(camera)) {
    widest = std::max(widest, angle_from_axis(ray));
    box.extend(Vector2d(ray.head<2>() / ray.z()));
  }
  if (widest > policy::kWidestAngle) throw too_wide(widest, "the picture");
  const double aspect = aspect_of(camera);
  const double fx =
      std::min(size.width / box.sizes().x(), size.height / (aspect * box.sizes().y()));
  return pinhole_about(box.center(), fx, aspect * fx, size);
}

Camera pinhole_of_valid_pixels(const Camera& camera, const ImageSize& size) {
  check_size(size);
  std::vector<Vector2d> outline;
  const double farthest = std::tan(policy::kWidestAngle);
  for (const Vector3d& ray : outline_rays(camera)) {
    const bool wide = angle_from_axis(ray) > policy::kWidestAngle;
    outline.push_back(wide ? Vector2d(farthest * ray.head<2>().normalized())
                           : Vector2d(ray.head<2>() / ray.z()));
  }
  const double aspect = aspect_of(camera);
  const double shape = size.height / (aspect * size.width);
  const auto [middle, half_width] = InnerRectangle(outline, shape).largest();
  if (!(half_width > 0)) throw Error("reproject: the picture has no valid region on its axis");
  const Vector2d corner = middle.cwiseAbs() + half_width * Vector2d(1, shape);
  if (corner.norm() > 0.999 * farthest)  // numeric: the corner lies on the circle of the limit
    throw too_wide(std::atan(corner.norm()), "the largest rectangle of valid pixels");
  const double fx = size.width / (2 * half_width);
  return pinhole_about(middle, fx, aspect * fx, size);
}

Camera pinhole_of_focal_length(const Camera& camera, double focal_px, const ImageSize& size) {
  check_size(size);
  if (!kind_of(camera.lens).is_central)
    throw Error("reproject: a parallel lens has no rays from one centre");
  if (!(focal_px > 0) || !std::isfinite(focal_px))
    throw Error("reproject: the focal length must be > 0, got " + short_number(focal_px));
  const auto p = parameters(camera.lens);
  const double cx = (p[2] + 0.5) * size.width / camera.image_size.width - 0.5;
  const double cy = (p[3] + 0.5) * size.height / camera.image_size.height - 0.5;
  return {pinhole(focal_px, focal_px * aspect_of(camera), cx, cy), size};
}

AngularRange angular_range(const Camera& camera) {
  std::vector<Vector3d> rays = outline_rays(camera);
  for (const Vector3d& ray : grid_rays(camera)) rays.push_back(ray);
  AngularRange range;
  for (const Vector3d& ray : rays) {
    const double longitude = std::atan2(ray.x(), ray.z());
    const double latitude = std::atan2(ray.y(), std::hypot(ray.x(), ray.z()));
    range.left_rad = std::min(range.left_rad, longitude);
    range.right_rad = std::max(range.right_rad, longitude);
    range.top_rad = std::min(range.top_rad, latitude);
    range.bottom_rad = std::max(range.bottom_rad, latitude);
    range.from_axis_rad = std::max(range.from_axis_rad, angle_from_axis(ray));
  }
  return range;
}

std::vector<TurnedCamera> several_pinholes(const Camera& camera, int count) {
  if (count < 2) throw Error("several pinholes: must be 2 or more, got " + std::to_string(count));
  const AngularRange range = angular_range(camera);
  const auto p = parameters(camera.lens);
  if (count == 5 || count == 6) return cube_faces(p[0], count);
  return fan(range, p[0], p[1], count);
}

Panorama panorama_of(const Camera& camera, PanoramaKind kind, double px_per_rad) {
  if (kind == PanoramaKind::transverse)
    throw Error("panorama: a transverse one is that of a rectified pair");
  const AngularRange range = angular_range(camera);
  Panorama panorama;
  panorama.kind = kind;
  panorama.px_per_rad = px_per_rad > 0 ? px_per_rad : parameters(camera.lens)[0];
  double top = range.top_rad, bottom = range.bottom_rad;
  if (kind == PanoramaKind::cylindrical) {
    top = std::tan(std::max(top, -policy::kCylinderLatitude));
    bottom = std::tan(std::min(bottom, policy::kCylinderLatitude));
  }
  const auto extent = [&](double from, double to) {
    // Limited to what an int holds; such a size is refused where a picture of it is made.
    return static_cast<int>(
        std::clamp(std::ceil(panorama.px_per_rad * (to - from)), 1.0, 1e9));  // numeric: see above
  };
  panorama.size = {extent(range.left_rad, range.right_rad), extent(top, bottom)};
  panorama.centre =
      image_centre(panorama.size) -
      panorama.px_per_rad / 2 * Vector2d(range.left_rad + range.right_rad, top + bottom);
  return panorama;
}

}  // namespace tagcal
