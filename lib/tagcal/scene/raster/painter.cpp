#include "tagcal/scene/raster/painter.hpp"

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

TagFamily family_of(const Board& board, const TagFamilies& families) {
  const auto kind = tag_kind(board);
  if (!kind) return {};
  const auto family = families.find(kind->family);
  if (family == families.end()) throw Error("render: family " + kind->family + " is not known");
  return family->second;
}

std::vector<Vector3d> moved(const Pose& target_from_source, std::span<const Vector3d> corners) {
  std::vector<Vector3d> result;
  for (const Vector3d& corner : corners) result.push_back(target_from_source * corner);
  return result;
}

}  // namespace

Painter::Painter(const Scene& scene, const TagFamilies& families, const Pose& camera_from_world,
                 int scale)
    : scene_(scene),
      families_(families),
      camera_from_world_(camera_from_world),
      light_(light_in_camera(scene, camera_from_world)),
      tracer_(scene.camera, scale),
      shadows_(scene, scene.camera.lens, camera_from_world) {}

Layer Painter::layer_of(std::size_t index, std::span<const std::size_t> hidden_by) const {
  const Sheet& sheet = shadows_.sheets()[index];
  Layer layer;
  const std::vector<Polygon> parts = seen_parts(sheet.corners, index, hidden_by);
  for (const Polygon& part : parts) tracer_.trace(part, layer.paper);
  layer.shading = shading_of(index);
  if (!sheet.panel) {
    layer.paper_level = static_cast<float>(scene_.occluders[sheet.occluder].level);
    return layer;
  }
  layer.paper_level = static_cast<float>(scene_.paper_level);
  layer.ink_level = static_cast<float>(scene_.ink_level);
  const bool whole = parts.size() == 1 && parts[0] == sheet.corners;
  if (shadows_.faces(index)) print(index, whole, hidden_by, layer.ink);
  return layer;
}

// The side that is turned to the eye is lit.
Shading Painter::shading_of(std::size_t index) const {
  if (!light_) return {};
  const Sheet& sheet = shadows_.sheets()[index];
  const Vector3d normal = shadows_.faces(index) ? sheet.normal : Vector3d(-sheet.normal);
  return {*light_, normal, sheet.corners.front()};
}

std::vector<Shadows::Polygon> Painter::seen_parts(const Polygon& polygon, std::size_t index,
                                                  std::span<const std::size_t> hidden_by) const {
  std::vector<Polygon> seen;
  for (const Polygon& part : tracer_.in_domain(polygon))
    for (Polygon& visible : shadows_.visible_parts(part, index, hidden_by))
      seen.push_back(std::move(visible));
  return seen;
}

// All cells are seen if the whole sheet is.
void Painter::print(std::size_t index, bool whole, std::span<const std::size_t> hidden_by,
                    Outlines& ink) const {
  const Sheet& sheet = shadows_.sheets()[index];
  const PlacedBoard& placed = scene_.boards[sheet.board];
  const Pose camera_from_board = camera_from_world_ * placed.world_from_board;
  for (const InkCell& cell :
       ink_cells(placed.board, *sheet.panel, family_of(placed.board, families_),
                 scene_.ink_spread_m, scene_.print_grid_m)) {
    const Polygon corners = moved(camera_from_board, cell);
    if (whole)
      tracer_.trace(corners, ink);
    else
      for (const Polygon& part : seen_parts(corners, index, hidden_by)) tracer_.trace(part, ink);
  }
}

}  // namespace tagcal::internal
