#include "tagcal/reproject/rows/pinhole_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/error.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/outline.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A ray at most 80 degrees from the axis z, on the same side of it.
Vector3d before_pinhole(const Vector3d& ray) {
  const double radius = ray.head<2>().norm();
  if (std::atan2(radius, ray.z()) <= policy::kWidestAngle) return ray;
  const Vector2d side = radius > 0 ? Vector2d(ray.head<2>() / radius) : Vector2d(1, 0);
  const double s = std::sin(policy::kWidestAngle), c = std::cos(policy::kWidestAngle);
  return {s * side.x(), s * side.y(), c};
}

// Inner and outer limits of what a camera sees in a pinhole of focal length 1 with its axis at the
// pixel (0, 0): of the pixels at the left, upper, right and lower border of its picture, and of
// all. Of a grid of 9 x 9 pixels, as in cv::stereoRectify.
struct Limits {
  Eigen::Array4d inner, outer;  // left, upper, right, lower
};

Limits limits_of(const Camera& camera, const Quaterniond& rectified_from_camera) {
  constexpr int kPoints = 9;  // across and down, as cv::stereoRectify
  constexpr double kMost = std::numeric_limits<double>::max();
  Limits limits{{-kMost, -kMost, kMost, kMost}, {kMost, kMost, -kMost, -kMost}};
  auto& [inner, outer] = limits;
  for (int y = 0; y < kPoints; ++y)
    for (int x = 0; x < kPoints; ++x) {
      const Vector2d pixel(x * (camera.image_size.width - 1.0) / (kPoints - 1),
                           y * (camera.image_size.height - 1.0) / (kPoints - 1));
      const Vector2d p =
          before_pinhole(rectified_from_camera * ray_or_last(camera, pixel)).hnormalized();
      outer << outer.head<2>().min(p.array()), outer.tail<2>().max(p.array());
      if (x == 0) inner[0] = std::max(inner[0], p.x());
      if (y == 0) inner[1] = std::max(inner[1], p.y());
      if (x == kPoints - 1) inner[2] = std::min(inner[2], p.x());
      if (y == kPoints - 1) inner[3] = std::min(inner[3], p.y());
    }
  return limits;
}

// Volatile, because GCC 12 drops the rounding where it computes two numbers at once.
double in_single_precision(double value) {
  const volatile float rounded = static_cast<float>(value);
  return rounded;
}

// The mean of the corners of a picture in a pinhole of a focal length with its axis at (0, 0). In
// single precision, as in cv::stereoRectify, so that the principal points are the same numbers.
Vector2d mean_corner(const Camera& camera, const Quaterniond& rectified_from_camera, double focal) {
  Vector2d sum = Vector2d::Zero();
  for (const double x : {0.0, camera.image_size.width - 1.0})
    for (const double y : {0.0, camera.image_size.height - 1.0}) {
      Vector3d ray = ray_or_last(camera, {x, y});
      if (ray.z() > 0) ray = (ray / ray.z()).unaryExpr(&in_single_precision).eval();
      const Vector3d turned = before_pinhole(rectified_from_camera * ray);
      sum += (focal * turned.hnormalized()).unaryExpr(&in_single_precision);
    }
  return sum / 4;
}

// The factor of the focal length with which the pinholes show nothing but pixels of the cameras
// (alpha 0), or all of them (1), about their principal points.
double zoom_of(double alpha, const std::array<Limits, 2>& limits, const PinholePair& pinholes,
               const ImageSize& size) {
  double least = -std::numeric_limits<double>::infinity();  // of alpha 0
  double most = std::numeric_limits<double>::infinity();
  const Eigen::Array4d sign(-1, -1, 1, 1);
  for (int k = 0; k < 2; ++k) {
    const Vector2d& c = pinholes.centre[k];
    const Eigen::Array4d sides(c.x(), c.y(), size.width - 1 - c.x(), size.height - 1 - c.y());
    least = std::max(least, (sides / (pinholes.focal_px * sign * limits[k].inner)).maxCoeff());
    most = std::min(most, (sides / (pinholes.focal_px * sign * limits[k].outer)).minCoeff());
  }
  return least * (1 - alpha) + most * alpha;
}

}  // namespace

Vector2d scale_on_axis(const KnownRig::Member& member) {
  const std::array<Vector3d, 1> axis = {Vector3d::UnitZ()};
  const auto rows = projection_rows(member.camera.camera.lens, Pose(), axis);
  if (!rows) throw Error("rectify: " + member.name + " has no pixel on its optical axis");
  return {rows->by_pose(0, 3), rows->by_pose(1, 4)};
}

PinholePair pinholes_of(const std::array<const KnownRig::Member*, 2>& members,
                        const PairOrientation& orientation, bool zero_disparity,
                        std::optional<double> alpha) {
  const ImageSize size = members[0]->camera.camera.image_size;
  PinholePair pinholes;
  const int across_baseline = orientation.is_vertical ? 0 : 1;
  for (const KnownRig::Member* member : members) {
    const ImageSize& own = member->camera.camera.image_size;
    const double ratio =
        orientation.is_vertical ? 1.0 * size.width / own.width : 1.0 * size.height / own.height;
    pinholes.focal_px += scale_on_axis(*member)[across_baseline] * ratio / 2;
  }
  const double own_focal_px = pinholes.focal_px;
  std::array<Limits, 2> limits;
  for (int k = 0; k < 2; ++k) {
    const Camera& camera = members[k]->camera.camera;
    const Quaterniond& turn = orientation.rectified_from_camera[k];
    limits[k] = limits_of(camera, turn);
    pinholes.centre[k] = Vector2d(size.width - 1, size.height - 1) / 2 -
                         mean_corner(camera, turn, pinholes.focal_px);
  }
  const Vector2d mean = (pinholes.centre[0] + pinholes.centre[1]) / 2;
  for (Vector2d& centre : pinholes.centre) {
    if (zero_disparity)
      centre = mean;
    else
      centre[across_baseline] = mean[across_baseline];
  }
  if (alpha) pinholes.focal_px *= zoom_of(*alpha, limits, pinholes, size);
  const double zoom = pinholes.focal_px / own_focal_px;
  if (!(zoom > 1 / policy::kMostRectifiedZoom && zoom < policy::kMostRectifiedZoom))
    throw Error(fmt::format(
        "rectify: the focal length of {} and {} would be {:.4g} px, that of the cameras is {:.4g} "
        "px: take another alpha, or longlat",
        members[0]->name, members[1]->name, pinholes.focal_px, own_focal_px));
  return pinholes;
}

}  // namespace tagcal::internal
