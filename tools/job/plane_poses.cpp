#include "job/plane_poses.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal::tools {
namespace {

using Points = std::map<CornerId, Eigen::Vector3d>;

std::vector<double> rectangle_around(const Points& points) {
  Eigen::AlignedBox2d box;
  for (const auto& [id, x] : points) box.extend(Eigen::Vector2d(x.head<2>()));
  const double margin = 0.1 * box.sizes().maxCoeff();
  return {box.min().x() - margin, box.min().y() - margin, box.max().x() + margin,
          box.max().y() + margin};
}

// The poses of the target in the pictures.
void estimate_poses(const PlaneRequest& request, PlanePoses& poses) {
  const CalibrationFile& file = *request.file;
  // Strict: the pictures stay those of the request, one by one.
  Input input = read_input({.target = request.target, .inputs = request.images, .strict = true});
  check_image_size(file.camera.image_size, request.camera, input);
  detect_views(input, request.threads, true, &file.camera);
  poses.warnings = input.warnings;
  const Points points = points_in_world(input.dataset.boards);
  poses.rectangle = rectangle_around(points);
  Progress progress("poses", static_cast<int>(request.images.size()));
  for (std::size_t i = 0; i < request.images.size(); ++i) {
    progress.update(static_cast<int>(i));
    const auto view = std::ranges::find(input.dataset.views, input.images[i].name, &View::image);
    PoseEstimate estimate;
    if (view != input.dataset.views.end())
      estimate =
          estimate_pose(view_correspondences(*view, points, file.camera_error_px), file.camera);
    if (is_answer(estimate.status))
      poses.camera_from_plane.emplace_back(i, estimate.camera_from_target());
    if (estimate.status != Status::ok)
      poses.warnings.push_back(fmt::format("{}: the pose of the target is {}", request.images[i],
                                           status_name(estimate.status)));
  }
}

}  // namespace

PlanePoses plane_poses(const PlaneRequest& request) {
  PlanePoses poses;
  if (request.view.empty()) {
    estimate_poses(request, poses);
    return poses;
  }
  if (!request.target.empty()) {
    const Board board = read_target(request.target, {}, &poses.warnings);
    poses.rectangle = rectangle_around(points_in_world({{board, Pose()}}));
  }
  const Pose pose = pose_of_view(request.camera, request.view);
  for (std::size_t i = 0; i < std::max<std::size_t>(1, request.images.size()); ++i)
    poses.camera_from_plane.emplace_back(i, pose);
  return poses;
}

}  // namespace tagcal::tools
