// The job `corners` of the chart: from a picture of one tag to its four corners, from one of a grid
// of circles to their centres, and whole pictures from and to PNG files.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "study/chart/chart_study.hpp"
#include "study/chart/circle_methods.hpp"
#include "study/chart/corner_methods.hpp"
#include "study/chart/picture_methods.hpp"
#include "study/peers/tag_peers.hpp"

namespace tagcal::study {
namespace {

constexpr double kGrossPx = 2;

std::vector<CornerMethod> corner_methods() {
  return {our_corners(),          our_corners_under_the_lens(), our_corners_of_edges(),
          apriltag_corners(true), apriltag_corners(false),      opencv_corners()};
}

class CornerErrors {
 public:
  void add(const TagCorners& found, const TagCorners& truth) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double e = (found[i] - truth[i]).squaredNorm();
      squares_ += e, largest_px_ = std::max(largest_px_, std::sqrt(e));
    }
    coordinates_ += 8;
  }

  double largest_px() const { return largest_px_; }
  double rms_px() const { return std::sqrt(squares_ / coordinates_); }  // of a coordinate

 private:
  double squares_ = 0, largest_px_ = 0;
  int coordinates_ = 0;
};

Verdict judge(const std::optional<CornerAnswer>& answer, const CornerTask& task) {
  if (!answer) return {};
  CornerErrors errors;
  errors.add(answer->corners, task.view.corners);
  return {!(errors.largest_px() < kGrossPx), errors.rms_px(), errors.rms_px() / task.bound_px()};
}

Verdict judge_picture(const std::vector<PeerTag>& found, const PictureTask& task) {
  CornerErrors errors;
  for (const auto& [id, truth] : task.corners) {
    const auto tag = std::ranges::find(found, id, &PeerTag::id);
    if (tag == found.end()) return {};
    errors.add(tag->corners, truth);
  }
  return {!(errors.rms_px() < kGrossPx), errors.rms_px(), errors.rms_px() / task.bound_px};
}

std::vector<Attempt> draw(TagViewSpec spec, const std::vector<CornerMethod>& methods,
                          Random& random) {
  spec.tilt_deg = random.uniform(0, 60);
  const auto task = std::make_shared<const CornerTask>(draw_corner_task(spec, random));
  return attempts_of(methods, *task, [task](const std::optional<CornerAnswer>& answer) {
    return judge(answer, *task);
  });
}

void add_pictures(const std::string& title, bool is_plain,
                  const std::vector<PictureMethod>& methods, ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {"pictures of 1280x800", "", title, {}};
  if (!has_aruco()) panel.panel.cannot = {"OpenCV aruco: not installed"};
  panel.methods = study.numbers_of(methods);
  panel.draw = [is_plain, methods](Random& random) {
    const PictureTask task = draw_picture_task(is_plain, random);
    return attempts_of(methods, task, [task](const std::vector<PeerTag>& found) {
      return judge_picture(found, task);
    });
  };
  study.panels.push_back(std::move(panel));
}

// Each centre is compared with the nearest found one: OpenCV may count from another end.
Verdict judge_circles(const std::vector<Eigen::Vector2d>& found, const CircleTask& task) {
  if (found.size() < task.centres.size()) return {};
  double squares = 0;
  for (const auto& [id, truth] : task.centres) {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& centre : found)
      least = std::min(least, (centre - truth).squaredNorm());
    squares += least;
  }
  const double rms_px = std::sqrt(squares / (2 * static_cast<double>(task.centres.size())));
  return {!(rms_px < kGrossPx), rms_px, rms_px / task.bound_px};
}

void add_circles(ChartStudy& study) {
  const std::vector<CircleMethod> methods = circle_methods();
  for (const double noise : {2.0, 8.0}) {
    StudyPanel panel;
    panel.panel = {"circles under a strong lens",
                   fmt::format("noise {:g} grey levels", noise),
                   "8 x 6 circles of 12 px",
                   {}};
    panel.methods = study.numbers_of(methods);
    panel.draw = [noise, methods](Random& random) {
      const CircleTask task = draw_circle_task(noise, random);
      return attempts_of(methods, task, [task](const std::vector<Eigen::Vector2d>& found) {
        return judge_circles(found, task);
      });
    };
    study.panels.push_back(std::move(panel));
  }
}

}  // namespace

ChartStudy corners_study() {
  ChartStudy study;
  study.error_unit = "pixels, a coordinate";
  study.bound_name = "Cramér-Rao bound under a known lens";
  study.failure =
      "a tag not found, or a corner off by more than 2 px (in pictures of many tags: RMS)";
  study.trials = 500;
  study.quick_trials = 30;
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
  add_circles(study);
  add_pictures("36 plain tags", true, picture_methods(), study);
  add_pictures("36 tags of Kalibr", false, picture_methods(), study);
  add_pictures("rendering of 36 tags of Kalibr", false, {render_method()}, study);
  return study;
}

}  // namespace tagcal::study
