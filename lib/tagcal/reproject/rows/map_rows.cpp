#include "tagcal/reproject/rows/map_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "tagcal/camera/kernels/project_dispatch.hpp"
#include "tagcal/error.hpp"
#include "tagcal/reproject/kernels/reproject_dispatch.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector3d kNoPoint = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

// A target whose points are start + u * right + v * down in its own frame.
struct AffineTarget {
  Vector3d start, right, down;
};

std::optional<AffineTarget> affine_target(const Target& target) {
  if (const auto* plane = std::get_if<PlaneRaster>(&target)) {
    const double m = plane->m_per_px;
    return AffineTarget{{plane->upper_left.x(), plane->upper_left.y(), 0}, {m, 0, 0}, {0, -m, 0}};
  }
  const auto* camera = std::get_if<Camera>(&target);
  const auto* lens = camera ? std::get_if<Perspective>(&camera->lens) : nullptr;
  if (!lens) return std::nullopt;
  const auto& p = lens->parameters();
  if (std::any_of(p.begin() + 4, p.end(), [](double k) { return k != 0; })) return std::nullopt;
  return AffineTarget{{-p[2] / p[0], -p[3] / p[1], 1}, {1 / p[0], 0, 0}, {0, 1 / p[1], 0}};
}

// The ray of a pixel of a target that is not affine; NaN if it has none.
Vector3d direction_at(const Camera& camera, const Vector2d& pixel) {
  const std::optional<Ray> ray = ray_in_camera(camera.lens, pixel);
  return ray ? ray->direction : kNoPoint;
}

// That of a transverse panorama is an equirectangular one, reflected in the diagonal.
Vector3d direction_at(const Panorama& panorama, const Vector2d& pixel) {
  if (panorama.kind == PanoramaKind::transverse) {
    const Panorama upright{
        PanoramaKind::equirectangular, panorama.px_per_rad, panorama.centre.reverse(), {}};
    const Vector3d direction = direction_at(upright, pixel.reverse());
    return {direction.y(), direction.x(), direction.z()};
  }
  const Vector2d angle = (pixel - panorama.centre) / panorama.px_per_rad;
  if (!(std::abs(angle.x()) <= std::numbers::pi)) return kNoPoint;
  const double s = std::sin(angle.x()), c = std::cos(angle.x());
  if (panorama.kind == PanoramaKind::cylindrical) return {s, angle.y(), c};
  if (!(std::abs(angle.y()) <= std::numbers::pi / 2)) return kNoPoint;
  const double across = std::cos(angle.y());
  return {across * s, std::sin(angle.y()), across * c};
}

// The viewer of a plane is on the side of +z: no picture from behind.
bool shows_front(const PlaneRaster&, const Camera& camera, const Pose& camera_from_plane) {
  const Vector3d normal = camera_from_plane.rotation_matrix().col(2);
  if (const auto* lens = std::get_if<Parallel>(&camera.lens))
    return normal.dot(lens->ray_in_camera({0, 0})->direction) < 0;
  return normal.dot(camera_from_plane.translation()) < 0;
}

// The chain target -> camera -> picture; immutable, shared by the functions of MapRows.
class Chain {
 public:
  explicit Chain(const Reprojection& r) : camera_(r.camera), target_(r.target) {
    const auto* plane = std::get_if<PlaneRaster>(&r.target);
    pose_ = plane ? r.camera_from_target : Pose(r.camera_from_target.rotation(), Vector3d::Zero());
    sees_ = !plane || shows_front(*plane, r.camera, pose_);
    if (const auto affine = affine_target(r.target)) {
      const Matrix3d turn = pose_.rotation_matrix();
      affine_ = {turn * affine->start + pose_.translation(), turn * affine->right,
                 turn * affine->down};
    }
    kind_ = set_lens(camera_.lens, 0, job_);
  }

  std::optional<Vector2d> at(const Vector2d& pixel) const {
    if (!sees_) return std::nullopt;
    if (affine_)
      return project(camera_.lens,
                     affine_->start + pixel.x() * affine_->right + pixel.y() * affine_->down);
    const Vector3d direction = direction_of(pixel);
    if (!direction.allFinite()) return std::nullopt;
    return project(camera_.lens, pose_ * direction);
  }

  void fill(int v, float* x, float* y) const {
    const int width = size_of(target_).width;
    if (!sees_) {
      std::fill_n(x, width, kNowhere);
      std::fill_n(y, width, kNowhere);
    } else if (affine_) {
      fill_affine(v, width, x, y);
    } else {
      fill_by_rays(v, width, x, y);
    }
  }

 private:
  Vector3d direction_of(const Vector2d& pixel) const {
    if (const auto* panorama = std::get_if<Panorama>(&target_))
      return direction_at(*panorama, pixel);
    return direction_at(std::get<Camera>(target_), pixel);
  }

  void fill_affine(int v, int width, float* x, float* y) const {
    MapRowJob job;
    static_cast<ViewJob&>(job) = job_;
    job.num_points = static_cast<unsigned long>(width);
    Eigen::Map<Vector3d>(job.start) = affine_->start + v * affine_->down;
    Eigen::Map<Vector3d>(job.step) = affine_->right;
    job.x = x;
    job.y = y;
    fastest_reproject_kernels().map_row[kind_](job);
  }

  void fill_by_rays(int v, int width, float* x, float* y) const {
    const std::size_t n = static_cast<std::size_t>(width);
    std::vector<Vector3d> directions(n);
    std::vector<Vector2d> pixels(n);
    std::vector<std::uint8_t> valid(n);
    for (int u = 0; u < width; ++u) directions[static_cast<std::size_t>(u)] = direction_of({u, v});
    project(camera_.lens, pose_, directions, pixels, valid);
    for (std::size_t u = 0; u < n; ++u) {
      x[u] = valid[u] ? static_cast<float>(pixels[u].x()) : kNowhere;
      y[u] = valid[u] ? static_cast<float>(pixels[u].y()) : kNowhere;
    }
  }

  Camera camera_;
  Target target_;
  Pose pose_;
  bool sees_ = true;
  std::optional<AffineTarget> affine_;  // in the camera frame
  ViewJob job_;
  ProjectKernelKind kind_;
};

bool is_parallel(const Camera& camera) { return !kind_of(camera.lens).is_central; }

void check(const Reprojection& r) {
  const ImageSize size = size_of(r.target);
  if (size.width <= 0 || size.height <= 0)
    throw Error("reproject: the target must have pixels, got " + std::to_string(size.width) + "x" +
                std::to_string(size.height));
  if (std::holds_alternative<PlaneRaster>(r.target)) return;
  const auto* camera = std::get_if<Camera>(&r.target);
  if (is_parallel(r.camera) || (camera && is_parallel(*camera)))
    throw Error(
        "reproject: a parallel lens has no rays from one centre: only a plane can be shown");
}

}  // namespace

MapRows map_rows(const Reprojection& reprojection) {
  check(reprojection);
  const auto chain = std::make_shared<const Chain>(reprojection);
  return {size_of(reprojection.target),
          [chain](int v, float* x, float* y) { chain->fill(v, x, y); },
          [chain](const Vector2d& pixel) { return chain->at(pixel); }};
}

MapRows map_rows(const PixelMap& map) {
  if (map.x.empty() || map.x.size() != map.y.size())
    throw Error("remap: the two images of the map must have one size, and pixels");
  const auto fill = [&map](int v, float* x, float* y) {
    std::copy_n(map.x.row(v), map.x.width(), x);
    std::copy_n(map.y.row(v), map.y.width(), y);
  };
  // Linear between the pixels of the map, and beyond them.
  const auto at = [&map](const Vector2d& pixel) -> std::optional<Vector2d> {
    const int u =
        std::clamp(static_cast<int>(std::floor(pixel.x())), 0, std::max(0, map.x.width() - 2));
    const int v =
        std::clamp(static_cast<int>(std::floor(pixel.y())), 0, std::max(0, map.x.height() - 2));
    const double fu = pixel.x() - u, fv = pixel.y() - v;
    const int right = std::min(u + 1, map.x.width() - 1),
              below = std::min(v + 1, map.x.height() - 1);
    Vector2d sum = Vector2d::Zero();
    for (const auto& [x, wx] : {std::pair(u, 1 - fu), std::pair(right, fu)}) {
      for (const auto& [y, wy] : {std::pair(v, 1 - fv), std::pair(below, fv)}) {
        const Vector2d corner(map.x(x, y), map.y(x, y));
        if (!corner.allFinite() || corner == Vector2d::Constant(kNowhere)) return std::nullopt;
        sum += wx * wy * corner;
      }
    }
    return sum;
  };
  return {map.x.size(), fill, at};
}

}  // namespace tagcal::internal
