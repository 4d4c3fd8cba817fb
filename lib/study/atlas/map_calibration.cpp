#include "study/atlas/map_calibration.hpp"

#include <cmath>
#include <memory>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCalibrationTrials = 300;
constexpr int kQuickTrials = 2;

// A method that throws has no answer.
Prepared<StabilityVerdict> judged_by(const std::shared_ptr<const CalibrationJudge>& judge,
                                     const CalibrationSolver& solver) {
  const bool fisheye = std::holds_alternative<Fisheye>(judge->question().good.lens);
  const bool may_refuse = !solver.lens.empty() && (solver.lens == "fisheye") != fisheye;
  return judged(guarded(solver.prepare(judge->question())),
                [judge, may_refuse](const std::optional<LensAnswer>& answer) {
                  LensAnswer none;
                  none.said = "no answer";
                  return judge->judge(answer.value_or(none), may_refuse);
                });
}

// 6 x 6 points, 0.6 m wide, about the origin of their plane.
Board small_grid() {
  Points board;
  const double half = 0.5 * (kSmallGrid - 1) * kSmallSpacingM;
  for (int i = 0; i < kSmallGrid * kSmallGrid; ++i)
    board.points.push_back(
        {{i, 0},
         {kSmallSpacingM * (i % kSmallGrid) - half, kSmallSpacingM * (i / kSmallGrid) - half, 0}});
  return {std::move(board), {}};
}

}  // namespace

void ask_calibration(StabilityMap& map, const std::vector<CalibrationSolver>& solvers,
                     const std::function<CalibrationQuestion(std::span<const double> at,
                                                             Random& random)>& question) {
  map.trials = kCalibrationTrials;
  map.peer_trials = 200;
  map.quick_trials = kQuickTrials;
  map.mark_over_map = true;
  for (const CalibrationSolver& s : solvers)
    map.methods.push_back({s.name, s.settings, s.ours, true});
  map.draw = [solvers, question](std::span<const double> at, Random& random) -> StabilityProblem {
    const auto judge = std::make_shared<const CalibrationJudge>(question(at, random));
    return [judge, solvers](std::size_t method) { return judged_by(judge, solvers[method]); };
  };
}

CalibrationTask empty_task(const Lens& lens, const std::string& model, double sigma_px) {
  CalibrationTask task{{}, lens, model, sigma_px, {}};
  task.dataset.image_size = {1280, 800};
  task.dataset.boards = {{small_grid(), Pose()}};
  return task;
}

CalibrationTask pinhole_task() { return empty_task(pinhole(900, 900, 651, 392), "f+c", 0.3); }

Pose draw_view(double tilt_deg, Random& random, double nearer) {
  const Vector3d centre(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double roll = random.uniform(0, 2 * std::numbers::pi);
  const double distance = nearer * random.uniform(0.9, 1.3);
  return camera_from_world_looking_at(
      centre + distance * cartesian_from_spherical({1, kDegree * tilt_deg, azimuth}), centre,
      Vector3d(std::cos(roll), std::sin(roll), 0.1));
}

CalibrationQuestion ask_all(CalibrationTask task, JudgedLens judged) {
  CalibrationQuestion question;
  question.dataset = task.dataset;
  question.good = std::move(task);
  question.judged = judged;
  return question;
}

std::vector<StabilityMap> calibration_maps() {
  return {views_tilt_map(),     parallel_planes_map(), roll_map(),
          repeated_views_map(), extrapolation_map(),   fold_map(),
          bent_board_map(),     wrong_lens_map(),      wrong_views_map(),
          board_unit_map()};
}

}  // namespace tagcal::study
