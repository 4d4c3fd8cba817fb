#include "study/tasks/pose_tasks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::study {

using Eigen::Vector2d;
using Eigen::Vector3d;

Camera study_camera() { return {pinhole(kStudyFocalPx, kStudyFocalPx, 639.5, 399.5), {1280, 800}}; }

std::vector<Vector3d> square_points(double side_m) {
  const double h = side_m / 2;
  return {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
}

std::vector<Vector3d> tag_grid_points(int n) {
  std::vector<Vector3d> points;
  for (const TargetPoint& p : target_points(make_board(AprilGrid{n, n, 0.528 / n, 0.3, 0})))
    points.push_back(p.position - Vector3d(0.33, 0.33, 0));
  return points;
}

std::vector<int> tag_grid_groups(int n) {
  std::vector<int> groups;
  for (int i = 0; i < 4 * n * n; ++i) groups.push_back(i / 4);
  return groups;
}

std::vector<Vector3d> space_points(std::size_t n, double side_m, Random& random) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back(side_m * Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                                       random.uniform(-0.5, 0.5)));
  return points;
}

std::vector<std::size_t> some_of(std::size_t n, std::size_t how_many, Random& random) {
  std::vector<std::size_t> all(n);
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (std::size_t i = 0; i < how_many; ++i) std::swap(all[i], all[i + random.index(n - i)]);
  all.resize(how_many);
  std::sort(all.begin(), all.end());
  return all;
}

PoseTask draw_task(const std::vector<Vector3d>& points, const ViewRange& range, Random& random) {
  PoseTask task;
  task.camera = study_camera();
  task.sigma_px = range.sigma_px;
  const double tilt = kDegree * random.uniform(range.min_tilt_deg, range.max_tilt_deg);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double roll = random.uniform(0, 2 * std::numbers::pi);
  const double distance = random.uniform(range.min_distance_m, range.max_distance_m);
  const Vector3d from(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                      std::cos(tilt));
  const Pose looking = camera_from_world_looking_at(distance * from, Vector3d::Zero(),
                                                    Vector3d(std::cos(roll), std::sin(roll), 0.1));
  Vector3d aside(random.uniform(-0.1, 0.1), random.uniform(-0.06, 0.06), 0);
  if (!range.aside) aside.setZero();
  task.camera_from_target = Pose(looking.rotation(), looking.translation() + distance * aside);
  for (const Vector3d& point : points) {
    Vector2d pixel = project(task.camera.lens, task.camera_from_target * point).value();
    pixel += range.sigma_px * Vector2d(random.normal(), random.normal());
    if (random.uniform() < range.wrong) pixel = {random.uniform(0, 1280), random.uniform(0, 800)};
    task.correspondences.push_back({point, pixel});
  }
  return task;
}

}  // namespace tagcal::study
