#include <Eigen/Geometry>
#include <algorithm>

#include "draw.hpp"

namespace tagcal {
namespace {

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
