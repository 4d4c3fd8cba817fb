// Maps of failure of rigs.

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>

#include "study/atlas/map_calibration.hpp"
#include "study/atlas/stability_judge.hpp"
#include "study/tasks/rig_tasks.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::study {
namespace {

constexpr double kKnownPlace = 0.05;  // rad, or m: the bound of a rig that must not be refused

// Judges by all places together. A warning says that an answer may be wrong.
struct RigJudge {
  RigTask task;
  Eigen::MatrixXd information;
  bool knowable = true;

  RigJudge(RigTask drawn, bool is_sound)
      : task(std::move(drawn)), information(rig_information(task)) {
    const auto bound = internal::exact_inverse(information);
    knowable = is_sound && bound && bound->size() > 0 &&
               std::sqrt(bound->diagonal().maxCoeff()) < kKnownPlace;
  }

  StabilityVerdict judge(const RigAnswer& answer) const {
    StabilityVerdict verdict;
    verdict.said = answer.said;
    const Eigen::VectorXd e = answer.error(task.rig);
    if (e.size() == 0) {
      if (knowable) verdict.outcome = StabilityOutcome::right_but_refused;
      return verdict;
    }
    if (information.size() > 0)
      verdict.over_bound = std::sqrt(e.dot(information * e) / static_cast<double>(e.size()));
    const auto claimed = internal::exact_inverse(answer.covariance);
    const double square = claimed && claimed->size() > 0 ? e.dot(*claimed * e)
                          : information.size() > 0       ? e.dot(information * e)
                                                         : std::numeric_limits<double>::infinity();
    if (square <= five_sigma_square(static_cast<int>(e.size())))
      verdict.outcome = StabilityOutcome::right_and_said;
    else
      verdict.outcome =
          answer.warned ? StabilityOutcome::wrong_and_said : StabilityOutcome::wrong_and_silent;
    return verdict;
  }
};

// `is_sound`: the data are as the methods assume them.
StabilityMap rig_map(const std::string& name, StabilityAxis axis,
                     const std::function<RigKind(double)>& kind,
                     const std::function<bool(double)>& is_sound) {
  StabilityMap map;
  map.name = name;
  map.axes = {std::move(axis)};
  map.trials = 300;
  map.peer_trials = 20;
  map.quick_trials = 2;
  map.mark_over_map = true;
  const std::vector<RigMethod> methods = rig_methods();
  for (const RigMethod& m : methods) map.methods.push_back({m.name, m.settings, m.ours(), true});
  map.draw = [methods, kind, is_sound](std::span<const double> at,
                                       Random& random) -> StabilityProblem {
    const auto judge =
        std::make_shared<const RigJudge>(draw_rig(kind(at[0]), random), is_sound(at[0]));
    return [judge, methods](std::size_t method) {
      return judged(guarded(methods[method].prepare(judge->task)),
                    [judge](const std::optional<RigAnswer>& answer) {
                      return judge->judge(answer.value_or(RigAnswer()));
                    });
    };
  };
  return map;
}

bool always(double) { return true; }
bool if_zero(double value) { return value == 0; }

}  // namespace

std::vector<StabilityMap> rig_maps() {
  std::vector<StabilityMap> maps;
  maps.push_back(rig_map(
      "rig-late", {"late by", "instants", {0, 0.02, 0.05, 0.1, 0.3, 1, 3}, {}},
      [](double late) { return RigKind{.late = late}; }, if_zero));
  maps.back().title = "Rig: a camera that is late, 20 instants of a board that moves steadily";
  maps.back().what = "A camera that lost a frame gives a wrong baseline beside small residuals";
  maps.back().why = "Poses of the board absorb most of a shift along its path";
  maps.back().answer = "tagcal holds the disagreement of a camera against the board's speed";

  maps.push_back(rig_map(
      "rig-overlap", {"common instants of 20", "", {0, 1, 2, 4, 10, 20}, {}},
      [](double count) { return RigKind{.common = count / 20}; }, [](double n) { return n > 0; }));
  maps.back().title = "Rig: instants at which both cameras see the board, of 20";
  maps.back().what = "Without a common view nothing connects two cameras";
  maps.back().why = "The places of the cameras are known by common instants only";
  maps.back().answer =
      "tagcal says `not_connected` and names the nearest views; one instant is a warning";

  maps.push_back(rig_map(
      "rig-spread", {"spread of the board", "", {0, 0.02, 0.1, 0.3, 1}, {}},
      [](double spread) { return RigKind{.spread = spread}; }, always));
  maps.back().title = "Rig: spread of the board's tilts and places, 20 instants";
  maps.back().what = "Views of a board that hardly moves leave lenses and places open";
  maps.back().why = "Focal length and distance trade for one tilt (Zhang, PAMI 2000)";
  maps.back().answer = "tagcal refuses a camera whose own pictures do not calibrate it";

  maps.push_back(rig_map(
      "rig-moved", {"moved by", "mm", {0, 0.5, 1, 3, 10, 50}, {}},
      [](double mm) { return RigKind{.moved_m = 1e-3 * mm}; }, if_zero));
  maps.back().title = "Rig: a camera that is knocked after two thirds of 20 instants";
  maps.back().what = "An answer for all instants is that of neither place";
  maps.back().why = "Least squares takes a place between both";
  maps.back().answer =
      "tagcal looks for a change of each camera's place, and answers for the "
      "longer part with the warning `camera_moved`";

  maps.push_back(rig_map(
      "rig-wheel", {"turns about other axes", "deg", {0, 0.5, 2, 5, 20}, {}},
      [](double degrees) { return RigKind{.is_wheel = true, .other_turns = kRadian * degrees}; },
      [](double degrees) { return degrees > 0; }));
  maps.back().title =
      "Rig: two cameras without a common view, on a body that turns about one axis by 30 deg";
  maps.back().what = "Turns about one axis leave the place along this axis open";
  maps.back().why = "AX = XB needs two axes (Park & Martin, IEEE Trans. Rob. Autom. 1994)";
  maps.back().answer = "tagcal says `extrinsic_not_observable`, with the axis";
  return maps;
}

}  // namespace tagcal::study
