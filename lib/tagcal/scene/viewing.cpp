#include "tagcal/scene/viewing.hpp"

#include <algorithm>
#include <limits>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

// The paper with a point.
std::size_t paper_of(const NamedPoint& point, const std::vector<Sheet>& sheets) {
  for (std::size_t i = 0; point.corner && i < sheets.size(); ++i)
    if (sheets[i].panel && sheets[i].board == point.board &&
        std::ranges::count(sheets[i].panel->points, *point.corner, &TargetPoint::id) > 0)
      return i;
  return Shadows::kNone;
}

void judge(const NamedPoint& point, const Scene& scene, const ViewingPipeline& pipeline,
           FollowedPoint& f) {
  f.sight = Sight::outside_domain;
  if (!f.pixel) return;
  f.sight = Sight::outside_image;
  if (!contains(pipeline.camera.image_size, *f.pixel)) return;
  const Shadows shadows(scene, pipeline.camera.lens, pipeline.camera_from_world);
  const std::size_t own = paper_of(point, shadows.sheets());
  if (const auto hider = shadows.seen_instead(f.in_camera, own)) {
    f.sight = Sight::hidden;
    f.hidden_by = sheet_name(scene, shadows.sheets()[*hider]);
    f.hit_in_world = pipeline.camera_from_world.inverse() * shadows.in_line(*hider, f.in_camera);
    return;
  }
  f.sight = own != Shadows::kNone && !shadows.faces(own) ? Sight::turned_away : Sight::seen;
}

std::string name_of(const CornerId& id, const Board& board) {
  const std::string number = std::to_string(id.tag_id);
  if (point_kind(board) == PointKind::circle_centre) return "circle " + number;
  if (checkers(board)) return "corner " + number;
  if (!tag_kind(board)) return "point " + number;
  return "tag " + number + " corner " + std::to_string(id.corner);
}

// The shear after which an oblique projection is orthographic; identity for other lenses.
Affine receding(const Lens& lens) {
  const auto* parallel = std::get_if<Parallel>(&lens);
  if (!parallel) return Affine::Identity();
  return shearing(Axis::x, Axis::z, parallel->parameters()[4]) *
         shearing(Axis::y, Axis::z, parallel->parameters()[5]);
}

}  // namespace

std::optional<Sighting> sighting(const Scene& scene, const Pose& camera_from_world,
                                 const Vector3d& x_in_world) {
  auto pixel = project(scene.camera.lens, camera_from_world * x_in_world);
  if (!pixel) return std::nullopt;
  if (!scene.is_rolling()) return Sighting{*pixel, camera_from_world};
  constexpr int kMostSteps = 100;   // numeric: a corner that moves by a third of a line per line
  constexpr double kClose = 1e-11;  // numeric: px, near the rounding of a pixel
  for (int step = 0; step < kMostSteps; ++step) {
    const double seconds = scene.sensor.shutter.seconds_at(*pixel, scene.camera.image_size);
    const Pose pose = moved_for(seconds, scene.velocity, camera_from_world);
    const auto next = project(scene.camera.lens, pose * x_in_world);
    if (!next) return std::nullopt;
    const double change = (*next - *pixel).norm();
    pixel = next;
    if (change < kClose) return Sighting{*pixel, pose};
  }
  return std::nullopt;
}

std::vector<Observation> visible_corners(const Scene& scene, const Pose& camera_from_world) {
  const std::vector<Sheet> in_world = sheets(scene);
  const Shadows middle(in_world, scene.camera.lens, camera_from_world);
  std::vector<Observation> seen;
  const auto look_at = [&](const CornerId& id, const Vector3d& x_in_world, std::size_t own) {
    const auto found = sighting(scene, camera_from_world, x_in_world);
    if (!found || !contains(scene.camera.image_size, found->pixel)) return;
    const Vector3d x = found->camera_from_world * x_in_world;
    const auto is_seen = [&](const Shadows& shadows) {
      return (own == Shadows::kNone || shadows.faces(own)) && !shadows.seen_instead(x, own);
    };
    if (scene.is_rolling() ? is_seen({in_world, scene.camera.lens, found->camera_from_world})
                           : is_seen(middle))
      seen.push_back({id, found->pixel, {}});
  };
  for (std::size_t own = 0; own < middle.sheets().size(); ++own) {
    const Sheet& sheet = middle.sheets()[own];
    if (!sheet.panel || !(scene.is_rolling() || middle.faces(own))) continue;
    const Pose& world_from_board = scene.boards[sheet.board].world_from_board;
    for (const TargetPoint& point : sheet.panel->points)
      look_at(point.id, world_from_board * point.position, own);
  }
  for (const PlacedBoard& placed : scene.boards) {
    if (point_kind(placed.board) != PointKind::measured) continue;  // they are on its sheets
    for (const TargetPoint& point : target_points(placed.board))
      look_at(point.id, placed.world_from_board * point.position, Shadows::kNone);
  }
  std::ranges::sort(seen, {}, &Observation::id);
  return seen;
}

std::optional<NamedPoint> named_corner(const Scene& scene, const CornerId& id) {
  for (std::size_t board = 0; board < scene.boards.size(); ++board)
    for (const TargetPoint& point : target_points(scene.boards[board].board))
      if (point.id == id) {
        return NamedPoint{name_of(id, scene.boards[board].board), board, point.position, id};
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
  judge(point, scene, pipeline, f);
  return f;
}

}  // namespace tagcal
