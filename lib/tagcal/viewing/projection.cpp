#include "tagcal/viewing/projection.hpp"

#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

// A direction counts as parallel to the image plane below this sine of its angle to it.
constexpr double kParallel = 1e-12;

// One metre of depth is drawn `length` metres long, at an angle from x towards -y.
Matrix4d receding_projection(double length, double angle_rad) {
  return oblique_projection({-length * std::cos(angle_rad), length * std::sin(angle_rad), 1});
}

}  // namespace

Matrix4d perspective_from_origin(double d_m) {
  if (!(d_m > 0) || std::isinf(d_m))
    throw Error("perspective: the plane of projection must be at a finite distance > 0");
  Matrix4d matrix = Vector4d(1, 1, 1, 0).asDiagonal();
  matrix(3, 2) = 1 / d_m;
  return matrix;
}

Matrix4d perspective_map() {
  Matrix4d matrix = Matrix4d::Identity();
  matrix.row(2).swap(matrix.row(3));
  return matrix;
}

Matrix4d perspective_from_behind(double d_m) {
  if (!(d_m > 0)) throw Error("perspective: the centre must be at a distance > 0");
  Matrix4d matrix = orthographic_projection();
  matrix(3, 2) = 1 / d_m;
  return matrix;
}

Matrix4d orthographic_projection() { return Vector4d(1, 1, 0, 1).asDiagonal(); }

Matrix4d oblique_projection(const Vector3d& direction) {
  if (!direction.allFinite() || !(std::abs(direction.z()) > kParallel * direction.norm()))
    throw Error("oblique projection: the direction is parallel to the plane of projection");
  Matrix4d matrix = orthographic_projection();
  matrix.block<2, 1>(0, 2) = -direction.head<2>() / direction.z();
  return matrix;
}

Matrix4d cavalier_projection(double angle_rad) { return receding_projection(1, angle_rad); }

Matrix4d cabinet_projection(double angle_rad) { return receding_projection(0.5, angle_rad); }

std::optional<Vector3d> divided(const Vector4d& homogeneous) {
  if (!(homogeneous.w() > 0)) return std::nullopt;
  return Vector3d(homogeneous.head<3>() / homogeneous.w());
}

Eigen::Quaterniond camera_from_world_drawn(DrawnView view) {
  const Vector3d zero = Vector3d::Zero(), up = Vector3d::UnitZ();
  switch (view) {
    case DrawnView::plan:
      return camera_from_world_looking_at(zero, -up, Vector3d::UnitY()).rotation();
    case DrawnView::front_elevation:
      return camera_from_world_looking_at(zero, Vector3d::UnitY(), up).rotation();
    case DrawnView::side_elevation:
      return camera_from_world_looking_at(zero, -Vector3d::UnitX(), up).rotation();
    case DrawnView::isometric:
      break;
  }
  return camera_from_world_looking_at({1, -1, 1}, zero, up).rotation();
}

std::vector<Vector2d> vanishing_points(const Lens& lens, const Vector3d& direction_in_camera) {
  std::vector<Vector2d> result;
  const LensKind& kind = kind_of(lens);
  if (!kind.is_central) return result;
  if (!kind.reaches_behind &&
      !(std::abs(direction_in_camera.z()) > kParallel * direction_in_camera.norm()))
    return result;
  for (const double sign : {1.0, -1.0})
    if (const auto pixel = project(lens, sign * direction_in_camera)) result.push_back(*pixel);
  return result;
}

int num_vanishing_axes(const Lens& lens, const Eigen::Quaterniond& camera_from_world) {
  int count = 0;
  for (int axis = 0; axis < 3; ++axis)
    count += !vanishing_points(lens, camera_from_world * Vector3d::Unit(axis)).empty();
  return count;
}

}  // namespace tagcal
