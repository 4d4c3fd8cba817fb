// The job `handeye` of the chart: the place of a camera on a robot's hand.

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>

#include "study/chart/chart_study.hpp"
#include "study/tasks/handeye_tasks.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {
namespace {

constexpr double kGrossHandeyeDegrees = 5;  // of a rotation, beyond which an answer is a failure

void add_panel(const std::string& page, const std::string& title, const HandeyeKind& kind,
               ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {page, "", title, {"MATLAB: not free"}};
  const auto methods = handeye_methods();
  panel.methods = study.numbers_of(methods);
  panel.draw = [kind, methods](Random& random) {
    const HandeyeTask task = draw_handeye(kind, random);
    const Pose truth = task.mount_from_camera;
    const Eigen::MatrixXd bound = handeye_bound(task);
    return attempts_of(methods, task, [truth, bound](const HandeyeAnswer& answer) -> Verdict {
      if (!answer.mount_from_camera || bound.size() == 0) return {};
      const Vector6d e = minus(truth, *answer.mount_from_camera);
      const double degrees = internal::degrees(1) * e.head<3>().norm();
      const double sigma_m = std::sqrt(bound.bottomRightCorner<3, 3>().trace());
      return {!(degrees < kGrossHandeyeDegrees), 1e3 * e.tail<3>().norm(),
              e.tail<3>().norm() / sigma_m};
    });
  };
  study.panels.push_back(std::move(panel));
}

}  // namespace

ChartStudy handeye_chart(bool quick) {
  ChartStudy study;
  study.error_unit = "translation, mm";
  study.bound_name = "Cramér-Rao bound for a known noise of the robot";
  study.failure = "no answer, or a rotation off by more than 5 degrees";
  study.trials = 200;
  study.quick_trials = 4;
  for (const int num_poses : quick ? std::vector<int>{5} : std::vector<int>{3, 5, 10, 30, 100})
    add_panel("robot 1 mm, 0.11 deg", fmt::format("{} poses", num_poses), {.num_poses = num_poses},
              study);
  if (quick) return study;
  for (const double degrees : {2.0, 10.0})
    add_panel("15 poses", fmt::format("spread of axes {:g} deg", degrees),
              {.axis_spread_rad = internal::radians(degrees)}, study);
  for (const double noise : {0.0, 3.0})
    add_panel("15 poses", fmt::format("robot {:g} mm, {:g} deg", noise, noise / 6),
              {.robot_sigma_m = 1e-3 * noise, .robot_sigma_rad = internal::radians(noise / 6)},
              study);
  return study;
}

}  // namespace tagcal::study
