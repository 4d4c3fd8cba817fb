#include "study/atlas/map_pose.hpp"
#include "study/chart/pose_methods.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

namespace tagcal::study {
namespace {

MapMethod named(const std::string& name, PoseJob job) {
  for (const PoseMethod& method : pose_methods(job))
    if (method.name == name) return {method, true};
  return {};
}

MapMethod of_unknown_noise(MapMethod method) {
  method.method.name += ", noise not stated";
  method.method.settings = "sigma_px not given";
  method.method.prepare = [prepare = method.method.prepare](PoseTask task) {
    task.sigma_px = 0;
    return prepare(task);
  };
  return method;
}

// A method that throws has no answer.
Prepared<StabilityVerdict> judged_by(const std::shared_ptr<const PoseJudge>& judge,
                                     const PoseMethod& method) {
  return judged(guarded(method.prepare(judge->task())),
                [judge](const std::optional<PoseAnswer>& answer) {
                  return judge->judge(answer.value_or(PoseAnswer{}));
                });
}

}  // namespace

MapMethod our_pose() { return named("tagcal estimate_pose", PoseJob::tag); }

MapMethod our_pose_and_focal() {
  return named("tagcal estimate_pose_and_focal", PoseJob::plane_focal);
}

MapMethod our_pose_of_unknown_noise() { return of_unknown_noise(our_pose()); }

MapMethod our_pose_and_focal_of_unknown_noise() { return of_unknown_noise(our_pose_and_focal()); }

MapMethod peer(const PoseMethod& method) { return {method, true}; }

MapMethod aside(const PoseMethod& method) { return {method, false}; }

void ask_pose(
    StabilityMap& map, const std::vector<MapMethod>& methods,
    const std::function<PoseQuestion(std::span<const double> at, Random& random)>& question) {
  auto solvers = std::make_shared<std::vector<PoseMethod>>();
  for (const MapMethod& m : methods) {
    const bool ours = m.method.name.starts_with("tagcal estimate_");
    map.methods.push_back({m.method.name, m.method.settings, ours, m.drawn});
    solvers->push_back(m.method);
  }
  map.draw = [solvers, question](std::span<const double> at, Random& random) -> StabilityProblem {
    const auto judge = std::make_shared<const PoseJudge>(question(at, random));
    return [judge, solvers](std::size_t method) { return judged_by(judge, (*solvers)[method]); };
  };
}

std::vector<std::size_t> all_of(const PoseTask& task) {
  std::vector<std::size_t> all(task.correspondences.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

PoseQuestion all_right(PoseTask task) {
  PoseQuestion question;
  question.task = std::move(task);
  question.right = all_of(question.task);
  return question;
}

void see(const std::vector<Eigen::Vector3d>& points, PoseTask& task, Random& random) {
  const auto p = parameters(task.camera.lens);
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector2d on_plane = (task.camera_from_target * point).hnormalized();
    const Eigen::Vector2d noise(random.normal(), random.normal());
    task.correspondences.push_back(
        {point, Eigen::Vector2d(p[0] * on_plane.x() + p[2], p[1] * on_plane.y() + p[3]) +
                    task.sigma_px * noise});
  }
}

bool beyond_chance(std::size_t n, std::size_t right, double sigma_px) {
  if (right < 4) return false;
  const auto log_choose = [](std::size_t all, std::size_t some) {
    double sum = 0;
    for (std::size_t i = 0; i < some; ++i)
      sum += std::log(static_cast<double>(all - i) / static_cast<double>(i + 1));
    return sum;
  };
  const std::size_t more = right - 4;  // than a sample
  const double radius = 5 * sigma_px;
  const double share = std::numbers::pi * radius * radius / (1280.0 * 800.0);
  return log_choose(n, 4) + log_choose(n - 4, more) + static_cast<double>(more) * std::log(share) <
         std::log(1e-4);
}

std::vector<StabilityMap> pose_maps() {
  return {tag_tilt_distance_map(),
          turns_map(),
          flatness_map(),
          line_map(),
          points_map(),
          near_camera_map(),
          behind_camera_map(),
          wrong_corners_map(),
          swapped_map(),
          bad_data_map(),
          units_map(),
          focal_tilt_map(),
          focal_distance_map()};
}

}  // namespace tagcal::study
