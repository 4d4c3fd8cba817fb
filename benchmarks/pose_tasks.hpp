#pragma once

// The views that the pose benchmarks solve: f = 900 px, 1280 x 800, drawn by seeds.

#include <cmath>
#include <numbers>

#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/study/pose_methods.hpp"

namespace tagcal {

constexpr double kDegree = std::numbers::pi / 180;

inline Camera benchmark_camera() { return {pinhole(900, 900, 639.5, 399.5), {1280, 800}}; }

inline std::vector<Eigen::Vector3d> square_points(double size) {
  const double h = size / 2;  // the order that IPPE_SQUARE asks for
  return {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
}

// 6 x 6 tags of 88 mm, 144 corners, about their centre.
inline std::vector<Eigen::Vector3d> board_points() {
  std::vector<Eigen::Vector3d> points;
  for (const TargetPoint& p : target_points(grid_board({6, 6, 0.088, 0.3, 0})))
    points.push_back(p.position - Eigen::Vector3d(0.33, 0.33, 0));
  return points;
}

inline std::vector<int> board_groups() {
  std::vector<int> groups;
  for (int i = 0; i < 144; ++i) groups.push_back(i / 4);
  return groups;
}

inline std::vector<Eigen::Vector3d> space_points(std::size_t n, double size, Random& random) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back(size * Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                                            random.uniform(-0.5, 0.5)));
  return points;
}

struct ViewRange {
  double min_tilt_deg = 0, max_tilt_deg = 52;
  double min_distance_m = 0.7, max_distance_m = 1.6;
  double sigma_px = 0.5;
  double wrong = 0;   // share of the corners that are anywhere in the image
  bool aside = true;  // off the optical axis; else the tilt is that to the image as well
};

// A view of points about the origin of their frame, from a random side.
inline PoseTask draw_task(const std::vector<Eigen::Vector3d>& points, const ViewRange& range,
                          Random& random) {
  using Eigen::Vector2d;
  using Eigen::Vector3d;
  PoseTask task;
  task.camera = benchmark_camera();
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

}  // namespace tagcal
