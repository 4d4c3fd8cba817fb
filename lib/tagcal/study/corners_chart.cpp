// The job `corners` of the chart: from a picture of one tag to its four corners.

#include <apriltag/apriltag.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tagcal/detect/apriltag_handles.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_edges.hpp"
#include "tagcal/detect/refine_tag.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/study/chart_study.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr const char* kFamily = "tag36h11";
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGrossPx = 2;

struct Cell {
  double side_px;
  double noise_levels;
};

struct CornerTask {
  Image8 image;
  double side_px = 0;
  int id = 0;
  TagPattern pattern;
  Quad truth;
  double bound_px = 0;  // RMS of a coordinate
};

using CornerAnswer = std::optional<Quad>;
using CornerMethod = Method<CornerTask, CornerAnswer>;

// A tag on white seen by a pinhole with a tilt of up to 60 degrees, in the middle of the picture
// but for a part of a pixel; black 30, white 220, blur 0.8 px.
Scene scene_of(const Cell& cell, int id, Random& random) {
  Scene scene;
  scene.boards.push_back({grid_board({1, 1, 1.0, 0.3, id}, kFamily, 1, false), Pose()});
  const int width = static_cast<int>(2.4 * cell.side_px) + 24;
  const double middle = 0.5 * (width - 1);
  scene.camera = {
      pinhole(900, 900, middle + random.uniform(-0.5, 0.5), middle + random.uniform(-0.5, 0.5)),
      {width, width}};
  scene.sensor = {1, 0.8, cell.noise_levels};
  scene.paper_level = 220 / 255.0;
  scene.ink_level = 30 / 255.0;
  scene.paper_margin_m = 2;
  return scene;
}

Pose pose_of(const Cell& cell, Random& random) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Quaterniond rotation(
      AngleAxisd(kDegree * random.uniform(0, 60),
                 Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
      AngleAxisd(random.uniform(0, 2 * std::numbers::pi), Vector3d::UnitZ()) *
      AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  return {rotation, Vector3d(0, 0, 900 / cell.side_px) - rotation * Vector3d(0.5, 0.5, 0)};
}

constexpr TagFitOptions straight() { return {.bend_sd_per_px = 0, .twist_sd_per_px2 = 0}; }

// The covariance of the fit to the picture without noise, under straight lines, in proportion to
// the noise of a pixel and its rounding.
double bound_px(const Image8& noiseless, const CornerTask& task, double noise_levels) {
  const TagFit exact = refine_tag(noiseless, task.pattern, task.truth, straight());
  if (exact.status != TagFitStatus::converged) return std::nan("");
  const double noise = std::sqrt(noise_levels * noise_levels + 1.0 / 12);
  return std::sqrt(exact.covariance_px2.trace() / 8) * noise / exact.noise_levels;
}

CornerTask draw_tag(const Cell& cell, Random& random) {
  const TagFamily family = tag_family(kFamily, 1);
  CornerTask task;
  task.side_px = cell.side_px;
  task.id = static_cast<int>(random.index(family.codes.size()));
  task.pattern = tag_pattern(family, task.id, 1);
  Scene scene = scene_of(cell, task.id, random);
  const Pose camera_from_world = pose_of(cell, random);
  const auto corners = tag_corners(scene.boards[0].board.tags[0]);
  for (std::size_t i = 0; i < 4; ++i)
    task.truth[i] = project(scene.camera.lens, camera_from_world * corners[i]).value();
  const ImageF light = render_light(scene, {{kFamily, family}}, camera_from_world);
  task.image = expose(light, scene.sensor, random.next());
  scene.sensor.noise_levels = 0;
  task.bound_px = bound_px(expose(light, scene.sensor, 0), task, cell.noise_levels);
  return task;
}

// AprilTag's detector for the calling thread: its families must not be made by two at once.
struct StockDetector {
  FamilyHandle family = create_family(kFamily, 1);
  DetectorHandle detector{apriltag_detector_create()};

  StockDetector() {
    apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
    detector->nthreads = 1;
    detector->quad_decimate = 1;
  }

  CornerAnswer find(const CornerTask& task, bool refine_edges) {
    detector->refine_edges = refine_edges;
    image_u8_t view = {task.image.width(), task.image.height(), task.image.width(),
                       const_cast<std::uint8_t*>(task.image.row(0))};
    const DetectionsHandle all(apriltag_detector_detect(detector.get(), &view));
    for (int i = 0; i < zarray_size(all.get()); ++i) {
      apriltag_detection_t* found = nullptr;
      zarray_get(all.get(), i, &found);
      if (found->id != task.id) continue;
      Quad corners;  // AprilTag's pixel centres are at 0.5
      for (std::size_t k = 0; k < 4; ++k) corners[k] = {found->p[k][0] - 0.5, found->p[k][1] - 0.5};
      return corners;
    }
    return std::nullopt;
  }
};

StockDetector& detector_of_this_thread() {
  static std::mutex one_at_a_time;
  thread_local std::unique_ptr<StockDetector> detector;
  if (!detector) {
    const std::scoped_lock lock(one_at_a_time);
    detector = std::make_unique<StockDetector>();
  }
  return *detector;
}

Quad with_subpix(const CornerTask& task, const Quad& start) {
  cv::Mat image(task.image.height(), task.image.width(), CV_8U,
                const_cast<std::uint8_t*>(task.image.row(0)));
  std::vector<cv::Point2f> corners;
  for (const Vector2d& c : start)
    corners.emplace_back(static_cast<float>(c.x()), static_cast<float>(c.y()));
  const int half = std::clamp(static_cast<int>(task.side_px / 8), 2, 5);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 30, 0.001});
  Quad result;
  for (std::size_t i = 0; i < 4; ++i) result[i] = {corners[i].x, corners[i].y};
  return result;
}

CornerAnswer with_fit(const CornerTask& task, const Quad& start, const TagFitOptions& options) {
  const TagFit fit = refine_tag(task.image, task.pattern, start, options);
  if (fit.status != TagFitStatus::converged) return std::nullopt;
  return fit.corners;
}

// From AprilTag's corners, with its refine_edges or without, by one more step.
using Refine = std::function<CornerAnswer(const CornerTask&, const Quad&)>;
CornerMethod method(const std::string& name, const std::string& settings, bool refine_edges,
                    const Refine& refine) {
  return {name,
          [=](const CornerTask& task) -> Prepared<CornerAnswer> {
            struct State {
              CornerTask task;
              CornerAnswer corners;
            };
            auto state = std::make_shared<State>(State{task, {}});
            return {[state, refine, refine_edges] {
                      state->corners = detector_of_this_thread().find(state->task, refine_edges);
                      if (state->corners) state->corners = refine(state->task, *state->corners);
                    },
                    [state] { return state->corners; }};
          },
          settings};
}

std::vector<CornerMethod> corner_methods() {
  const auto as_found = [](const CornerTask&, const Quad& q) { return CornerAnswer(q); };
  return {
      method("tagcal fit", "AprilTag's detector, then refine_tag; the lens not known", true,
             [](const CornerTask& t, const Quad& q) { return with_fit(t, q, {}); }),
      method("tagcal fit, straight lens", "the same with a lens known to be straight", true,
             [](const CornerTask& t, const Quad& q) { return with_fit(t, q, straight()); }),
      method("tagcal edges", "AprilTag's detector, then refine_edges of ours", true,
             [](const CornerTask& t, const Quad& q) { return refine_edges(t.image, q, {}); }),
      method("AprilTag, refine_edges on", "quad_decimate 1, one thread, 0.5 px subtracted", true,
             as_found),
      method("AprilTag, refine_edges off", "quad_decimate 1, one thread, 0.5 px subtracted", false,
             as_found),
      method("OpenCV cornerSubPix",
             "from AprilTag's corners (refine_edges off), half a window of an eighth of the tag (2 "
             "to 5 px), 30 iterations, 0.001 px",
             false,
             [](const CornerTask& t, const Quad& q) { return CornerAnswer(with_subpix(t, q)); })};
}

Verdict judge(const CornerAnswer& answer, const CornerTask& task) {
  if (!answer) return {};
  double squares = 0, largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double e = ((*answer)[i] - task.truth[i]).squaredNorm();
    squares += e, largest = std::max(largest, std::sqrt(e));
  }
  const double rms = std::sqrt(squares / 8);
  return {!(largest < kGrossPx), rms, rms / task.bound_px};
}

std::vector<Attempt> draw(const Cell& cell, const std::vector<CornerMethod>& methods,
                          Random& random) {
  const auto task = std::make_shared<const CornerTask>(draw_tag(cell, random));
  std::vector<Attempt> attempts;
  for (const CornerMethod& m : methods) {
    Prepared<CornerAnswer> prepared = m.prepare(*task);
    attempts.push_back({std::move(prepared.solve), [task, answer = std::move(prepared.answer)] {
                          return judge(answer(), *task);
                        }});
  }
  return attempts;
}

}  // namespace

ChartStudy corners_study() {
  ChartStudy study;
  study.error_unit = "pixels, a coordinate";
  study.bound_name = "Cramér-Rao bound of a straight lens";
  study.failure = "the tag not found, not refined, or a corner off by more than 2 px";
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
      for (const CornerMethod& m : methods)
        panel.methods.push_back(
            study.number_of({m.name, m.settings, m.name.starts_with("tagcal")}));
      const Cell cell{side, noise};
      panel.draw = [cell, methods](Random& random) { return draw(cell, methods, random); };
      study.panels.push_back(std::move(panel));
    }
  return study;
}

}  // namespace tagcal
