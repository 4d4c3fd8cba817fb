#include "study/tasks/board_view.hpp"

#include <Eigen/Geometry>
#include <numbers>
#include <optional>

#include "tagcal/detect/families.hpp"

namespace tagcal::study {

using Eigen::Vector3d;

namespace {

// No value if a corner is within a pixel of the border of the picture.
std::optional<TagCorners> whole(const Tag& tag, const Camera& camera,
                                const Pose& camera_from_world) {
  const auto corners = tag_corners(tag);
  TagCorners result;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = project(camera.lens, camera_from_world * corners[i]);
    if (!pixel || pixel->minCoeff() <= 1 || pixel->x() >= camera.image_size.width - 2 ||
        pixel->y() >= camera.image_size.height - 2)
      return std::nullopt;
    result[i] = *pixel;
  }
  return result;
}

}  // namespace

BoardScene::BoardScene(const ImageSize& size, bool is_plain)
    : families({{"tag36h11", tag_family("tag36h11", is_plain ? 1 : 2)}}) {
  const double f = 0.8 * size.width;
  scene.camera = {Perspective({f, f, 0.5 * size.width - 0.5, 0.5 * size.height - 0.5, -0.2, 0.05}),
                  size};
  const AprilGrid grid{6, 6, 0.088, 0.3, 0, "tag36h11", is_plain ? 1 : 2, !is_plain};
  scene.boards = {{make_board(grid), Pose()}};
  scene.sensor = {1, 0.8, 3};
}

std::map<int, TagCorners> BoardScene::whole_tags(const Pose& camera_from_world) const {
  std::map<int, TagCorners> tags;
  for (const Tag& tag : tags_of(board().board))
    if (const auto corners = whole(tag, scene.camera, camera_from_world))
      tags.emplace(tag.id, *corners);
  return tags;
}

Pose board_pose(const Vector3d& tilt_axis, double aside_m) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(0.5, tilt_axis.normalized()) * facing;
  return Pose(turn, Vector3d(aside_m, 0, 0.95) - turn * Vector3d(0.33, 0.33, 0));
}

}  // namespace tagcal::study
