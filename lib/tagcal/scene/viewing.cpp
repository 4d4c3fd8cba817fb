#include "tagcal/scene/viewing.hpp"

#include <algorithm>
#include <limits>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/visibility/sheets.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

struct Watcher {
  const Scene& scene;
  Pose camera_from_world;
  Eye at;
  std::vector<Sheet> all;

  // `own` is the paper that the point is on, if any.
  void look_at(const CornerId& id, const Vector3d& x_in_world, const Sheet* own,
               std::vector<Observation>& seen) const {
    const auto pixel = project(scene.camera.lens, camera_from_world * x_in_world);
    if (!pixel || !contains(scene.camera.image_size, *pixel)) return;
    for (const Sheet& sheet : all)
      if (&sheet != own && hides(sheet, at, x_in_world)) return;
    seen.push_back({id, *pixel, {}});
  }
};

Sight sight_of(const NamedPoint& point, const FollowedPoint& f, const Scene& scene,
               const ViewingPipeline& pipeline) {
  if (!f.pixel) return Sight::outside_domain;
  if (!contains(pipeline.camera.image_size, *f.pixel)) return Sight::outside_image;
  const Eye at = eye(pipeline.camera.lens, pipeline.camera_from_world);
  const auto hides_it = [&](const Sheet& sheet) { return hides(sheet, at, f.in_world); };
  const bool hidden = std::ranges::any_of(sheets(scene), hides_it);
  if (!point.corner) return hidden ? Sight::hidden : Sight::seen;
  // visible_corners decides if the corner is seen; the rest finds the reason why it is not.
  const auto seen = visible_corners(scene, pipeline.camera_from_world);
  if (std::ranges::find(seen, *point.corner, &Observation::id) != seen.end()) return Sight::seen;
  return hidden ? Sight::hidden : Sight::turned_away;
}

// The shear after which an oblique projection is orthographic; identity for other lenses.
Affine receding(const Lens& lens) {
  const auto* parallel = std::get_if<Parallel>(&lens);
  if (!parallel) return Affine::Identity();
  return shearing(Axis::x, Axis::z, parallel->parameters()[4]) *
         shearing(Axis::y, Axis::z, parallel->parameters()[5]);
}

}  // namespace

std::vector<Observation> visible_corners(const Scene& scene, const Pose& camera_from_world) {
  const Watcher watcher{scene, camera_from_world, eye(scene.camera.lens, camera_from_world),
                        sheets(scene)};
  std::vector<Observation> seen;
  for (const Sheet& sheet : watcher.all) {
    if (!sheet.panel || !faces(sheet, watcher.at)) continue;
    const Pose& world_from_board = scene.boards[sheet.board].world_from_board;
    for (const Tag& tag : sheet.panel->tags) {
      const auto corners = tag_corners(tag);
      for (int i = 0; i < 4; ++i)
        watcher.look_at({tag.id, i}, world_from_board * corners[static_cast<std::size_t>(i)],
                        &sheet, seen);
    }
  }
  for (const PlacedBoard& placed : scene.boards)
    for (const TargetPoint& point : placed.board.points)
      watcher.look_at(point.id, placed.world_from_board * point.position, nullptr, seen);
  std::ranges::sort(seen, {}, &Observation::id);
  return seen;
}

std::optional<NamedPoint> named_corner(const Scene& scene, const CornerId& id) {
  for (std::size_t board = 0; board < scene.boards.size(); ++board)
    for (const TargetPoint& point : target_points(scene.boards[board].board))
      if (point.id == id) {
        std::string name =
            scene.boards[board].board.tags.empty()
                ? "point " + std::to_string(id.tag_id)
                : "tag " + std::to_string(id.tag_id) + " corner " + std::to_string(id.corner);
        return NamedPoint{std::move(name), board, point.position, id};
      }
  return std::nullopt;
}

ViewingPipeline viewing_pipeline(const Camera& camera, const Pose& camera_from_world, double near_m,
                                 double far_m) {
  ViewingPipeline pipeline;
  pipeline.camera = camera;
  pipeline.camera_from_world = camera_from_world;
  pipeline.eye_from_camera = opengl_from_opencv().matrix() * receding(camera.lens).matrix();
  pipeline.volume = view_volume(undistorted(camera), near_m, far_m);
  pipeline.clip_from_eye = clip_from_eye(pipeline.volume);
  pipeline.raster_from_ndc = raster_from_ndc({camera.image_size});
  return pipeline;
}

NearFar enclosing_planes(const Scene& scene, const Pose& camera_from_world) {
  double least = std::numeric_limits<double>::infinity(), greatest = 0;
  const auto add = [&](const Vector3d& x_in_world) {
    const double depth = (camera_from_world * x_in_world).z();
    if (!(depth > 0)) return;
    least = std::min(least, depth);
    greatest = std::max(greatest, depth);
  };
  for (const Sheet& sheet : sheets(scene)) std::ranges::for_each(sheet.corners, add);
  for (const auto& [id, x] : points_in_world(scene.boards)) add(x);
  return greatest > 0 ? NearFar{least / 2, greatest * 2} : NearFar{0.1, 100};
}

std::string_view sight_text(Sight sight) {
  switch (sight) {
    case Sight::seen:
      return "seen";
    case Sight::outside_domain:
      return "not seen: behind the camera or beyond its lens";
    case Sight::outside_image:
      return "not seen: outside the image";
    case Sight::turned_away:
      return "not seen: on the back of its board";
    case Sight::hidden:
      break;
  }
  return "not seen: hidden by something nearer";
}

FollowedPoint followed(const NamedPoint& point, const Scene& scene,
                       const ViewingPipeline& pipeline) {
  FollowedPoint f;
  f.in_world = point.position;
  if (point.board) {
    f.in_board = point.position;
    f.in_world = scene.boards[*point.board].world_from_board * point.position;
  }
  f.in_camera = pipeline.camera_from_world * f.in_world;
  f.in_eye = (pipeline.eye_from_camera * f.in_camera.homogeneous()).head<3>();
  f.in_clip = pipeline.clip_from_eye * f.in_eye.homogeneous();
  f.in_volume = in_clip_volume(f.in_clip);
  f.in_ndc = divided(f.in_clip);
  if (f.in_ndc) {
    const Vector4d raster = pipeline.raster_from_ndc * f.in_ndc->homogeneous();
    f.in_raster_px = raster.head<2>();
  }
  f.pixel = project(pipeline.camera.lens, f.in_camera);
  f.sight = sight_of(point, f, scene, pipeline);
  return f;
}

}  // namespace tagcal
