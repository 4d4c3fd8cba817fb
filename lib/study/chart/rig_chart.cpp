// The job `rig` of the chart: the places of cameras on one body.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>

#include "study/chart/chart_study.hpp"
#include "study/peers/mrcal_peer.hpp"
#include "study/tasks/rig_tasks.hpp"
#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {
namespace {

constexpr double kGrossDegrees = 5;  // of a rotation, beyond which an answer is a failure

// The rotations of all cameras, or their distances from the first.
struct RigTruth {
  RigDataset rig;
  Eigen::MatrixXd bound;  // covariance
  bool of_rotation = true;

  Verdict judge(const RigAnswer& answer) const {
    const Eigen::VectorXd e = answer.error(rig);
    if (e.size() == 0 || bound.size() == 0) return {};
    double square = 0, over_bound = 0, rotation = 0;
    const auto n = e.size() / 6;
    for (Eigen::Index c = 0; c < n; ++c) {
      const Eigen::Matrix<double, 6, 6> of_camera = bound.block<6, 6>(6 * c, 6 * c);
      const Eigen::Vector3d turn = e.segment<3>(6 * c), shift = e.segment<3>(6 * c + 3);
      rotation = std::max(rotation, turn.norm());
      if (of_rotation) {
        square += turn.squaredNorm();
        over_bound += turn.dot(of_camera.topLeftCorner<3, 3>().inverse() * turn) / 3;
        continue;
      }
      const Eigen::Vector3d along =
          rig.truth->camera_from_rig[static_cast<std::size_t>(c + 1)].translation().normalized();
      square += std::pow(along.dot(shift), 2);
      over_bound +=
          std::pow(along.dot(shift), 2) / along.dot(of_camera.bottomRightCorner<3, 3>() * along);
    }
    const double unit = of_rotation ? internal::degrees(1) : 1e3;
    return {!(rotation < internal::radians(kGrossDegrees)),
            unit * std::sqrt(square / static_cast<double>(n)),
            std::sqrt(over_bound / static_cast<double>(n))};
  }
};

void add_panel(const RigKind& kind, bool of_rotation, ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {"",
                 of_rotation ? "rotation" : "baseline",
                 fmt::format("{} cameras, {} instants", kind.num_cameras, kind.num_instants),
                 {}};
  if (!has_mrcal()) panel.panel.cannot.emplace_back("mrcal: not there when this was built");
  const auto methods = rig_methods(kind);
  panel.methods = study.numbers_of(methods);
  panel.draw = [kind, of_rotation, methods](Random& random) {
    const RigTask task = draw_rig(kind, random);
    const auto bound = internal::exact_inverse(rig_information(task));
    auto truth = std::make_shared<RigTruth>(
        RigTruth{task.rig, bound.value_or(Eigen::MatrixXd()), of_rotation});
    return attempts_of(methods, task,
                       [truth](const RigAnswer& answer) { return truth->judge(answer); });
  };
  study.panels.push_back(std::move(panel));
}

}  // namespace

ChartStudy rig_study(bool quick) {
  ChartStudy study;
  study.error_unit = "rotation, degrees; baseline, mm";
  study.bound_name = "Cramér-Rao bound";
  study.failure = "no answer, or a rotation off by more than 5 degrees";
  study.trials = 40;
  study.quick_trials = 4;
  using Sizes = std::vector<std::pair<int, int>>;
  for (const auto& [cameras, instants] :
       quick ? Sizes{{2, 5}, {2, 10}} : Sizes{{2, 5}, {2, 20}, {2, 100}, {4, 20}})
    for (const bool of_rotation : {true, false})
      add_panel({.num_cameras = cameras, .num_instants = instants, .is_grid = true}, of_rotation,
                study);
  return study;
}

}  // namespace tagcal::study
