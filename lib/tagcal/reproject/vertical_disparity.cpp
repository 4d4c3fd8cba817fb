#include <algorithm>
#include <cmath>

#include "tagcal/reproject/rectify.hpp"
#include "tagcal/reproject/rows/pinhole_pair.hpp"
#include "tagcal/uncertainty/rays/seen_ray.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A coordinate of the pixel of a direction in a target, and its derivative by the direction.
struct Coordinate {
  double px = 0;
  Eigen::RowVector3d by_direction;
};

// Across the baseline: rows, or columns of a vertical pair. No value behind a pinhole.
std::optional<Coordinate> coordinate_across(const Target& target, bool is_vertical,
                                            const Vector3d& d) {
  const int i = is_vertical ? 0 : 1;
  Coordinate coordinate;
  coordinate.by_direction.setZero();
  if (const auto* camera = std::get_if<Camera>(&target)) {
    if (!(d.z() > 0)) return std::nullopt;
    const auto p = parameters(camera->lens);
    const auto k = static_cast<std::size_t>(i);
    coordinate.px = p[k] * d[i] / d.z() + p[k + 2];
    coordinate.by_direction[i] = p[k] / d.z();
    coordinate.by_direction[2] = -p[k] * d[i] / (d.z() * d.z());
    return coordinate;
  }
  const Panorama& panorama = std::get<Panorama>(target);
  const double square = d[i] * d[i] + d.z() * d.z();
  if (!(square > 0)) return std::nullopt;
  coordinate.px = panorama.px_per_rad * std::atan2(d[i], d.z()) + panorama.centre[i];
  coordinate.by_direction[i] = panorama.px_per_rad * d.z() / square;
  coordinate.by_direction[2] = -panorama.px_per_rad * d[i] / square;
  return coordinate;
}

// The distances of the point of two unit rays from the centres of the cameras, inverse; 0 if the
// rays do not meet before them. `translation`: of the second camera.
std::array<double, 2> inverse_distances(const std::array<Vector3d, 2>& rays,
                                        const Vector3d& translation) {
  const Vector3d shift = rays[1].cross(translation);
  const double inverse = std::max(0.0, -rays[1].cross(rays[0]).dot(shift) / shift.squaredNorm());
  if (!std::isfinite(inverse)) return {0, 0};
  return {inverse, inverse / (rays[0] + inverse * translation).norm()};
}

}  // namespace

std::optional<Vector2d> rectified_pixel(const KnownRig& rig, const RectifiedPair& pair,
                                        std::size_t k, const Vector2d& pixel) {
  const auto ray = ray_in_camera(rig.cameras[pair.cameras[k]].camera.camera.lens, pixel);
  if (!ray) return std::nullopt;
  const Vector3d d = pair.camera_from_rectified[k].rotation().inverse() * ray->direction;
  if (const auto* camera = std::get_if<Camera>(&pair.targets[k])) return project(camera->lens, d);
  const Panorama& panorama = std::get<Panorama>(pair.targets[k]);
  const Vector2d angles = pair.is_vertical
                              ? Vector2d(transverse_angles({d.y(), d.x(), d.z()}).reverse())
                              : transverse_angles(d);
  return panorama.centre + panorama.px_per_rad * angles;
}

std::optional<VerticalDisparity> vertical_disparity(const KnownRig& rig, const RectifiedPair& pair,
                                                    const std::array<UncertainPixel, 2>& seen) {
  rig.check_covariance();
  std::array<std::optional<SeenRay>, 2> rays;
  std::array<Vector3d, 2> directions;  // in the rectified frame
  for (std::size_t k = 0; k < 2; ++k) {
    const UncertainCamera& camera = rig.cameras[pair.cameras[k]].camera;
    rays[k] = seen_ray(camera.camera.lens, seen[k].pixel,
                       camera.model ? camera.model->free() : std::span<const FreeParameter>());
    if (!rays[k]) return std::nullopt;
    directions[k] = pair.camera_from_rectified[k].rotation().inverse() * rays[k]->direction;
  }
  const auto inverse_m =
      inverse_distances(directions, pair.translation_m * Vector3d::Unit(pair.is_vertical ? 1 : 0));
  VerticalDisparity result;
  double noise = 0;
  Eigen::RowVectorXd by_rig = Eigen::RowVectorXd::Zero(rig.covariance.cols());
  for (std::size_t k = 0; k < 2; ++k) {
    const auto at = coordinate_across(pair.targets[k], pair.is_vertical, directions[k]);
    if (!at) return std::nullopt;
    const double sign = k == 0 ? 1 : -1;
    result.difference_px += sign * at->px;
    const Matrix3d turn = pair.camera_from_rectified[k].rotation_matrix().transpose();
    const Eigen::RowVector2d by_pixel = at->by_direction * turn * rays[k]->by_pixel;
    noise += by_pixel.dot(by_pixel * seen[k].covariance_px2);
    const double error = rig.cameras[pair.cameras[k]].camera_error_px.value_or(0);
    noise += error * error * by_pixel.squaredNorm();
    if (rig.covariance.size() == 0) continue;
    const auto c = static_cast<Eigen::Index>(pair.cameras[k]);
    Eigen::Matrix<double, 2, 6> by_place = rays[k]->pixel_by_pose;
    by_place.rightCols<3>() *= inverse_m[k];
    by_rig.segment<6>(6 * c) += sign * by_pixel * by_place;
    const auto& by_lens = rays[k]->pixel_by_parameters;
    by_rig.segment(rig.first_of_lens(pair.cameras[k]), by_lens.cols()) += sign * by_pixel * by_lens;
  }
  const double of_rig =
      rig.covariance.size() == 0 ? 0 : std::max(0.0, by_rig.dot(by_rig * rig.covariance));
  result.sigma_of_rig_px = std::sqrt(of_rig);
  result.sigma_px = std::sqrt(of_rig + noise);
  return result;
}

}  // namespace tagcal
