#include "study/tasks/calibration_tasks.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "study/tasks/pose_tasks.hpp"
#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSigmaPx = 0.3;

Pose draw_pose(Random& random) {
  const Vector3d centre(0.33 + random.uniform(-0.15, 0.15), 0.33 + random.uniform(-0.15, 0.15), 0);
  const double tilt = kDegree * random.uniform(0, 50), distance = random.uniform(0.8, 1.4);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double roll = random.uniform(0, 2 * std::numbers::pi);
  return camera_from_world_looking_at(
      centre + distance * cartesian_from_spherical({1, tilt, azimuth}), centre,
      Vector3d(std::cos(roll), std::sin(roll), 0.1));
}

}  // namespace

void add_view(CalibrationTask& task, const Pose& camera_from_board, Random& random,
              const std::function<bool(const Vector2d&)>& seen) {
  View view{std::to_string(task.dataset.views.size()), {}};
  for (const TargetPoint& p : target_points(task.dataset.boards[0].board)) {
    const auto pixel = project(task.lens, camera_from_board * p.position);
    const Vector2d noise = task.sigma_px * Vector2d(random.normal(), random.normal());
    if (!pixel || !contains(task.dataset.image_size, *pixel) || (seen && !seen(*pixel))) continue;
    view.observations.push_back({p.id, *pixel + noise, {}});
  }
  task.dataset.views.push_back(std::move(view));
  task.camera_from_board.push_back(camera_from_board);
}

CalibrationTask draw_calibration(const Lens& lens, const std::string& model, int num_views,
                                 Random& random) {
  CalibrationTask task{{}, lens, model, kSigmaPx, {}};
  task.dataset.image_size = {1280, 800};
  task.dataset.boards = {
      {make_board(Checkerboard{kGridPoints, kGridPoints, kGridSpacingM, kGridSpacingM}), Pose()}};
  for (int i = 0; i < num_views; ++i) add_view(task, draw_pose(random), random);
  return task;
}

Eigen::MatrixXd calibration_information(const CalibrationTask& task) {
  const std::vector<FreeParameter>& free = Model::named(task.model).free();
  const auto k = static_cast<Eigen::Index>(free.size());
  using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::vector<TargetPoint> board = target_points(task.dataset.boards[0].board);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(k, k);
  for (std::size_t i = 0; i < task.dataset.views.size(); ++i) {
    std::vector<Vector3d> points;
    for (const Observation& o : task.dataset.views[i].observations)
      points.push_back(board[static_cast<std::size_t>(o.id.tag_id)].position);
    const std::size_t n = points.size();
    if (n < 4) continue;
    std::vector<Vector2d> pixels(n);
    std::vector<std::uint8_t> valid(n);
    RowMajorX by_pose(2 * n, 6), by_free(2 * n, k);
    if (project_with_jacobians(
            task.lens, task.camera_from_board[i], points, free,
            {pixels, valid, {by_pose.data(), 12 * n}, {by_free.data(), 2 * n * free.size()}}) < n)
      continue;
    const Eigen::MatrixXd both = by_pose.transpose() * by_free;
    information += by_free.transpose() * by_free -
                   both.transpose() * (by_pose.transpose() * by_pose).ldlt().solve(both);
  }
  return information / (task.sigma_px * task.sigma_px);
}

}  // namespace tagcal::study
