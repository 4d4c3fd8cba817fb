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

struct RigMap {
  std::string name, title, what, why, answer;  // as of StabilityMap
  StabilityAxis axis;
  std::function<RigKind(double)> kind;
  std::function<bool(double)> is_sound;  // the data are as the methods assume them
};

StabilityMap map_of(const RigMap& rigs) {
  StabilityMap map;
  map.name = rigs.name;
  map.title = rigs.title;
  map.what = rigs.what;
  map.why = rigs.why;
  map.answer = rigs.answer;
  map.axes = {rigs.axis};
  map.trials = 300;
  map.peer_trials = 20;
  map.quick_trials = 2;
  map.mark_over_map = true;
  const std::vector<RigMethod> methods = rig_methods();
  for (const RigMethod& m : methods) map.methods.push_back({m.name, m.settings, m.ours(), true});
  map.draw = [methods, kind = rigs.kind, is_sound = rigs.is_sound](
                 std::span<const double> at, Random& random) -> StabilityProblem {
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

const RigMap kRigMaps[] = {
    {"rig-late",
     "Rig: a camera that is late, 20 instants of a board that moves steadily",
     "A camera that lost a frame gives a wrong baseline beside small residuals",
     "Poses of the board absorb most of a shift along its path",
     "tagcal holds the disagreement of a camera against the board's speed",
     {"late by", "instants", {0, 0.02, 0.05, 0.1, 0.3, 1, 3}, {}},
     [](double late) { return RigKind{.late = late}; },
     if_zero},
    {"rig-overlap",
     "Rig: instants at which both cameras see the board, of 20",
     "Without a common view nothing connects two cameras",
     "The places of the cameras are known by common instants only",
     "tagcal says `not_connected` and names the nearest views; one instant is a warning",
     {"common instants of 20", "", {0, 1, 2, 4, 10, 20}, {}},
     [](double count) { return RigKind{.common = count / 20}; },
     [](double n) { return n > 0; }},
    {"rig-spread",
     "Rig: spread of the board's tilts and places, 20 instants",
     "Views of a board that hardly moves leave lenses and places open",
     "Focal length and distance trade for one tilt (Zhang, PAMI 2000)",
     "tagcal refuses a camera whose own pictures do not calibrate it",
     {"spread of the board", "", {0, 0.02, 0.1, 0.3, 1}, {}},
     [](double spread) { return RigKind{.spread = spread}; },
     always},
    {"rig-moved",
     "Rig: a camera that is knocked after two thirds of 20 instants",
     "An answer for all instants is that of neither place",
     "Least squares takes a place between both",
     "tagcal looks for a change of each camera's place, and answers for the "
     "longer part with the warning `camera_moved`",
     {"moved by", "mm", {0, 0.5, 1, 3, 10, 50}, {}},
     [](double mm) { return RigKind{.moved_m = 1e-3 * mm}; },
     if_zero},
    {"rig-wheel",
     "Rig: two cameras without a common view, on a body that turns about one axis by 30 deg",
     "Turns about one axis leave the place along this axis open",
     "AX = XB needs two axes (Park & Martin, IEEE Trans. Rob. Autom. 1994)",
     "tagcal says `extrinsic_not_observable`, with the axis",
     {"turns about other axes", "deg", {0, 0.5, 2, 5, 20}, {}},
     [](double degrees) { return RigKind{.is_wheel = true, .other_turns = kDegree * degrees}; },
     [](double degrees) { return degrees > 0; }}};

}  // namespace

std::vector<StabilityMap> rig_maps() {
  std::vector<StabilityMap> maps;
  for (const RigMap& rigs : kRigMaps) maps.push_back(map_of(rigs));
  return maps;
}

}  // namespace tagcal::study
