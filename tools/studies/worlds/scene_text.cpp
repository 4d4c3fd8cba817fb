#include "draw.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tagcal/camera/model.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
namespace {

std::string camera_text(const Scene& scene) {
  const auto p = parameters(scene.camera.lens);
  const ImageSize& size = scene.camera.image_size;
  std::vector<double> distortion;
  for (const FreeParameter& parameter : Model::named(scene.model).free())
    for (const int i : parameter.lens_parameters)
      if (i >= 4) distortion.push_back(p[static_cast<std::size_t>(i)]);
  return fmt::format(
      "camera: {{image_size: [{}, {}], model: {}, fx: {}, fy: {}, cx: {}, cy: {}, "
      "distortion: [{}]}}\n",
      size.width, size.height, scene.model, p[0], p[1], p[2], p[3], fmt::join(distortion, ", "));
}

std::string target_text(const Tags& board) {
  std::vector<std::string> tags;
  for (const Tag& tag : board.tags)
    tags.push_back(fmt::format("{{id: {}, size: {}, pose: {}}}", tag.id, tag.size,
                               internal::pose_yaml(tag.board_from_tag)));
  return fmt::format(
      "  - target: {{target_type: tags, family: {}, border_bits: {}, corner_squares: false, tags: "
      "[\n      {}]}}\n",
      board.family, board.border_bits, fmt::join(tags, ",\n      "));
}

std::string target_text(const AprilGrid& grid) {
  return fmt::format(
      "  - target: {{target_type: aprilgrid, family: {}, tagCols: {}, tagRows: {}, tagSize: {}, "
      "tagSpacing: {}, border_bits: {}, corner_squares: {}}}\n    first_id: {}\n",
      grid.family, grid.columns, grid.rows, grid.tag_size, grid.tag_spacing, grid.border_bits,
      grid.corner_squares, grid.first_id);
}

std::string board_text(const PlacedBoard& placed) {
  const BoardPattern& pattern = placed.board.pattern;
  const auto* const grid = std::get_if<AprilGrid>(&pattern);
  return (grid ? target_text(*grid) : target_text(std::get<Tags>(pattern))) +
         "    world_from_board: " + internal::pose_yaml(placed.world_from_board) + "\n";
}

std::string light_text(const Light& light) {
  const auto& lamp = std::get<PointLamp>(light.lamp);
  return fmt::format("light: {{ambient: {}, point: {{position_m: [{}, {}, {}], strength: {}}}}}\n",
                     light.ambient, lamp.position.x(), lamp.position.y(), lamp.position.z(),
                     lamp.strength);
}

std::string processing_text(const Sensor& sensor) {
  std::string text;
  if (const auto& focus = sensor.focus)
    text += fmt::format(", focus: {{distance_m: {}, f_number: 1, focal_mm: {}}}", focus->distance_m,
                        1000 * focus->aperture_m);
  if (const auto& mosaic = sensor.mosaic)
    text += fmt::format(", mosaic: {{pattern: {}, gains: [{}], demosaic: {}}}", mosaic->pattern,
                        fmt::join(mosaic->gains, ", "), mosaic->demosaic);
  if (const auto& denoise = sensor.denoise)
    text += fmt::format(", denoise: {{levels: {}, radius_px: {}}}", denoise->levels,
                        denoise->radius_px);
  if (const auto& sharpen = sensor.sharpen)
    text += fmt::format(", sharpen: {{amount: {}, radius_px: {}}}", sharpen->amount,
                        sharpen->radius_px);
  if (sensor.jpeg) text += fmt::format(", jpeg: {}", *sensor.jpeg);
  return text;
}

std::string sensor_text(const Sensor& sensor) {
  const std::vector<double>& losses = sensor.vignetting.polynomial;
  return fmt::format(
      "sensor: {{exposure: {}, blur_px: {}, noise_levels: {}, bits: {}, gamma: {}{}{}}}\n",
      sensor.exposure, sensor.blur_px, sensor.noise_levels, sensor.bits, sensor.gamma,
      losses.empty() ? "" : fmt::format(", vignetting: [{}]", fmt::join(losses, ", ")),
      processing_text(sensor));
}

std::string occluder_text(const Occluder& occluder) {
  std::vector<std::string> corners;
  for (const Eigen::Vector3d& x : occluder.corners)
    corners.push_back(fmt::format("[{}, {}, {}]", x.x(), x.y(), x.z()));
  return fmt::format("  - {{corners: [{}], level: {}}}\n", fmt::join(corners, ", "),
                     occluder.level);
}

using Eigen::Vector3d;

// Share of the gap between tags by which the paper of each tag is wider than the tag. The papers of
// neighbours must not meet, because in different planes one would hide the other's rim.
constexpr double kPaperOfGap = 0.3;

// The flat square in the middle of a tag's moved corners.
Tag tag_near(const Tag& tag, const RealBoard& board) {
  std::array<Vector3d, 4> x = tag_corners(tag);
  for (Vector3d& corner : x) corner = board.place_of(corner);
  const Vector3d normal = (x[2] - x[0]).cross(x[3] - x[1]).normalized();
  const Vector3d right = (x[1] - x[0] + x[2] - x[3]).normalized();
  Eigen::Matrix3d axes;
  axes << right, normal.cross(right), normal;
  const Vector3d centre = (x[0] + x[1] + x[2] + x[3]) / 4;
  return {tag.id, tag.size, Pose(Eigen::Quaterniond(axes), centre)};
}

// White paper behind all tags, so that the gaps between them are white.
Occluder backing(const Tags& board, double margin_m, double level) {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (const Tag& tag : board.tags) {
    for (const Vector3d& corner : tag_corners(tag)) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const double z = low.z() - 1e-4 * (high - low).norm();
  low.array() -= margin_m;
  high.array() += margin_m;
  return {{{low.x(), low.y(), z},
           {high.x(), low.y(), z},
           {high.x(), high.y(), z},
           {low.x(), high.y(), z}},
          level,
          "backing"};
}

}  // namespace

std::string scene_text(const Scene& scene) {
  std::string text = camera_text(scene) + "boards:\n";
  for (const PlacedBoard& placed : scene.boards) text += board_text(placed);
  if (!scene.occluders.empty()) text += "occluders:\n";
  for (const Occluder& occluder : scene.occluders) text += occluder_text(occluder);
  text += "path:\n  type: poses\n  camera_from_world:\n";
  for (const Pose& pose : std::get<ExplicitPath>(scene.path).camera_from_world)
    text += "    - " + internal::pose_yaml(pose) + "\n";
  text += sensor_text(scene.sensor);
  if (scene.light) text += light_text(*scene.light);
  return text + fmt::format(
                    "background_level: {}\npaper_level: {}\nink_level: {}\nink_spread_m: "
                    "{}\nprint_grid_m: {}\npaper_margin_m: {}\n",
                    scene.background_level, scene.paper_level, scene.ink_level, scene.ink_spread_m,
                    scene.print_grid_m, scene.paper_margin_m);
}

Scene real_scene(const World& world) {
  Scene scene = world.scene;
  if (!world.defects.of_board()) return scene;
  Board& board = scene.boards[0].board;
  const RealBoard real(board, world.defects);
  const auto grid = std::get<AprilGrid>(board.pattern);
  Tags tags{grid.family, grid.border_bits, tags_of(board)};
  for (Tag& tag : tags.tags) tag = tag_near(tag, real);
  scene.occluders = {backing(tags, scene.paper_margin_m, scene.paper_level)};
  scene.paper_margin_m = kPaperOfGap * grid.tag_spacing * grid.tag_size;
  board.pattern = std::move(tags);
  return scene;
}

}  // namespace tagcal
