#include "tagcal/scene/surfaces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

Vector3d area_vector(const std::vector<Vector3d>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    sum += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  return sum / 2;
}

Sheet occluder_sheet(const Occluder& occluder, std::size_t index) {
  if (occluder.corners.size() < 3 || !(area_vector(occluder.corners).norm() > 0))
    throw Error(fmt::format("scene: occluders[{}].corners: must span an area", index));
  Sheet sheet;
  sheet.corners = occluder.corners;
  sheet.occluder = index;
  return sheet;
}

Sheet paper_sheet(const PlacedBoard& placed, std::size_t board, const BoardPanel& panel) {
  Sheet sheet;
  for (const Vector3d& corner : panel.paper)
    sheet.corners.push_back(placed.world_from_board * corner);
  sheet.board = board;
  sheet.panel = std::make_shared<BoardPanel>(panel);
  return sheet;
}

}  // namespace

std::vector<Sheet> sheets(const Scene& scene) {
  std::vector<Sheet> result;
  for (std::size_t i = 0; i < scene.occluders.size(); ++i)
    result.push_back(occluder_sheet(scene.occluders[i], i));
  for (std::size_t i = 0; i < scene.boards.size(); ++i)
    for (const BoardPanel& panel : board_panels(scene.boards[i].board, scene.paper_margin_m))
      result.push_back(paper_sheet(scene.boards[i], i, panel));
  for (Sheet& sheet : result) sheet = in_frame(std::move(sheet), Pose());
  return result;
}

Sheet in_frame(Sheet sheet, const Pose& target_from_world) {
  for (Vector3d& corner : sheet.corners) corner = target_from_world * corner;
  sheet.normal = area_vector(sheet.corners).normalized();
  return sheet;
}

std::string sheet_name(const Scene& scene, const Sheet& sheet) {
  if (sheet.panel) return fmt::format("board {}", sheet.board);
  const std::string& name = scene.occluders[sheet.occluder].name;
  return name.empty() ? fmt::format("occluder {}", sheet.occluder) : name;
}

}  // namespace tagcal
