// Maps of failure of hand-eye calibrations.

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>

#include "study/atlas/map_calibration.hpp"
#include "study/atlas/stability_judge.hpp"
#include "study/tasks/handeye_tasks.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {
namespace {

// Judges by the claim of the method or, without one, by the bound for a known noise of the robot.
// Data with a mistake, or that leave the place open, may be refused.
struct HandeyeJudge {
  HandeyeTask task;
  Eigen::MatrixXd bound;
  bool knowable = true;

  StabilityVerdict judge(const HandeyeAnswer& answer) const {
    StabilityVerdict verdict;
    verdict.said = answer.said;
    if (!answer.answered || !answer.mount_from_camera) {
      if (knowable) verdict.outcome = StabilityOutcome::right_but_refused;
      return verdict;
    }
    const Eigen::VectorXd e = minus(task.mount_from_camera, *answer.mount_from_camera);
    if (bound.size() > 0) verdict.over_bound = std::sqrt(e.dot(bound.ldlt().solve(e)) / 6);
    const Eigen::MatrixXd& claimed = answer.covariance.size() > 0 ? answer.covariance : bound;
    const double square = claimed.size() > 0 ? e.dot(claimed.ldlt().solve(e))
                                             : std::numeric_limits<double>::infinity();
    verdict.outcome = square <= five_sigma_square(6) ? StabilityOutcome::right_and_said
                                                     : StabilityOutcome::wrong_and_silent;
    return verdict;
  }
};

StabilityMap handeye_map(const std::string& name, StabilityAxis axis,
                         const std::function<HandeyeKind(double)>& kind,
                         const std::function<bool(double)>& is_knowable) {
  StabilityMap map;
  map.name = name;
  map.axes = {std::move(axis)};
  map.trials = 300;
  map.peer_trials = 200;
  map.quick_trials = 2;
  map.mark_over_map = true;
  const std::vector<HandeyeMethod> methods = handeye_methods();
  for (const HandeyeMethod& m : methods)
    map.methods.push_back({m.name, m.settings, m.ours(), true});
  map.draw = [methods, kind, is_knowable](std::span<const double> at,
                                          Random& random) -> StabilityProblem {
    HandeyeTask task = draw_handeye(kind(at[0]), random);
    Eigen::MatrixXd bound = handeye_bound(task);
    const auto judge = std::make_shared<const HandeyeJudge>(
        HandeyeJudge{std::move(task), std::move(bound), is_knowable(at[0])});
    return [judge, methods](std::size_t method) {
      return judged(guarded(methods[method].prepare(judge->task)),
                    [judge](const std::optional<HandeyeAnswer>& answer) {
                      return judge->judge(answer.value_or(HandeyeAnswer()));
                    });
    };
  };
  return map;
}

}  // namespace

std::vector<StabilityMap> handeye_maps() {
  std::vector<StabilityMap> maps;
  maps.push_back(handeye_map(
      "handeye-axes", {"spread of the axes", "deg", {0, 0.5, 2, 5, 10, 40}, {}},
      [](double degrees) { return HandeyeKind{.axis_spread_rad = internal::radians(degrees)}; },
      [](double degrees) { return degrees >= 40; }));
  maps.back().title = "Hand-eye: spread of the rotation axes, 15 poses, robot 1 mm and 0.11 deg";
  maps.back().what = "Turns about one axis leave the camera's place along it open";
  maps.back().why = "AX = XB needs two axes (Tsai & Lenz, IEEE Trans. Rob. Autom. 1989)";
  maps.back().answer = "tagcal says `rotation_axes_parallel`, with the axis";

  maps.push_back(handeye_map(
      "handeye-mistakes",
      {"robot's poses",
       "",
       {0, 1, 2, 3, 4},
       {"right", "inverse", "millimetres", "quaternion order", "next picture's"}},
      [](double mistake) {
        return HandeyeKind{.mistake = static_cast<RobotMistake>(static_cast<int>(mistake))};
      },
      [](double mistake) { return mistake == 0; }));
  maps.back().title = "Hand-eye: robot poses that are read in a wrong way, 15 poses";
  maps.back().what = "A file in another convention gives an answer, and no error";
  maps.back().why = "A least-squares answer exists for any poses";
  maps.back().answer = "tagcal names the reading that fits, `wrong_direction` or `not_synchronous`";
  return maps;
}

}  // namespace tagcal::study
