// The job `corners` of the chart: from a picture of one tag to its four corners.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "study/chart/chart_study.hpp"
#include "study/chart/corner_methods.hpp"

namespace tagcal::study {
namespace {

constexpr double kGrossPx = 2;

std::vector<CornerMethod> corner_methods() {
  return {our_corners(),          our_corners_under_the_lens(), our_corners_of_edges(),
          apriltag_corners(true), apriltag_corners(false),      opencv_corners()};
}

Verdict judge(const std::optional<CornerAnswer>& answer, const CornerTask& task) {
  if (!answer) return {};
  double squares = 0, largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double e = (answer->corners[i] - task.view.corners[i]).squaredNorm();
    squares += e, largest = std::max(largest, std::sqrt(e));
  }
  const double rms = std::sqrt(squares / 8);
  return {!(largest < kGrossPx), rms, rms / task.bound_px()};
}

std::vector<Attempt> draw(TagViewSpec spec, const std::vector<CornerMethod>& methods,
                          Random& random) {
  spec.tilt_deg = random.uniform(0, 60);
  const auto task = std::make_shared<const CornerTask>(draw_corner_task(spec, random));
  return attempts_of(methods, *task, [task](const std::optional<CornerAnswer>& answer) {
    return judge(answer, *task);
  });
}

}  // namespace

ChartStudy corners_study() {
  ChartStudy study;
  study.error_unit = "pixels, a coordinate";
  study.bound_name = "Cramér-Rao bound under a known lens";
  study.failure = "the tag not found, or a corner off by more than 2 px";
  study.trials = 500;
  study.quick_trials = 100;
  const std::vector<CornerMethod> methods = corner_methods();
  for (const double noise : {2.0, 8.0})
    for (const double side : {20.0, 40.0, 80.0}) {
      StudyPanel panel;
      panel.panel = {"",
                     fmt::format("noise {:g} grey levels", noise),
                     fmt::format("tag {:g} px wide", side),
                     {}};
      panel.methods = study.numbers_of(methods);
      TagViewSpec spec;
      spec.side_px = side;
      spec.noise_levels = noise;
      panel.draw = [spec, methods](Random& random) { return draw(spec, methods, random); };
      study.panels.push_back(std::move(panel));
    }
  return study;
}

}  // namespace tagcal::study
