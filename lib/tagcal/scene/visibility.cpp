#include "tagcal/scene/visibility.hpp"

#include <algorithm>

#include "tagcal/scene/sheets.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

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

}  // namespace tagcal
