// The job `project` of the chart: many points through a lens.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "study/chart/chart_study.hpp"
#include "tagcal/camera/kernels/project_dispatch.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Exact = long double;
using ExactPoint = std::array<Exact, 3>;

constexpr std::size_t kPoints = 1000;

struct Cell {
  Lens lens;
  std::string_view model;
  bool jacobians = false;
};

// One camera pose with its rotation vector, as in OpenCV, and the points.
struct ProjectTask {
  Lens lens = pinhole(1, 1, 0, 0);
  std::vector<FreeParameter>
      free;  // parameters of the Jacobian, beside the pose; empty: pixels only
  Vector3d turn, translation;
  std::vector<Vector3d> points;
};

using Pixels = std::vector<Vector2d>;
using ProjectMethod = Method<ProjectTask, Pixels>;

ProjectTask draw_points(const Cell& cell, Random& random) {
  ProjectTask task;
  task.lens = cell.lens;
  if (cell.jacobians) task.free = Model::named(cell.model).free();
  const auto small = [&](double most) { return random.uniform(-most, most); };
  task.turn = {small(0.2), small(0.2), small(1)};
  task.translation = {small(0.1), small(0.1), small(0.2)};
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double z = random.uniform(1, 3);
    task.points.emplace_back(z * small(0.4), z * small(0.3), z);
  }
  return task;
}

// The rotation about v by |v| (Rodrigues' formula).
ExactPoint turned(const Vector3d& v, const ExactPoint& x) {
  const Exact angle = std::sqrt(Exact(v.x()) * v.x() + Exact(v.y()) * v.y() + Exact(v.z()) * v.z());
  const ExactPoint k = {v.x() / angle, v.y() / angle, v.z() / angle};
  const Exact s = std::sin(angle), c = std::cos(angle);
  const Exact along = (k[0] * x[0] + k[1] * x[1] + k[2] * x[2]) * (1 - c);
  ExactPoint y;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
    y[i] = x[i] * c + (k[j] * x[l] - k[l] * x[j]) * s + k[i] * along;
  }
  return y;
}

std::array<Exact, 2> distorted(const Perspective::Parameters& p, Exact x, Exact y) {
  const Exact s = x * x + y * y;
  const Exact scale = (1 + s * (p[4] + s * (p[5] + s * Exact(p[8])))) /
                      (1 + s * (p[9] + s * (p[10] + s * Exact(p[11]))));
  return {x * scale + 2 * Exact(p[6]) * x * y + p[7] * (s + 2 * x * x),
          y * scale + p[6] * (s + 2 * y * y) + 2 * Exact(p[7]) * x * y};
}

// The truth of this study, written from the definitions in camera/lens.hpp without the library.
std::array<Exact, 2> exact_pixel(const ProjectTask& task, const Vector3d& point) {
  ExactPoint x = turned(task.turn, {point.x(), point.y(), point.z()});
  for (int i = 0; i < 3; ++i) x[static_cast<std::size_t>(i)] += task.translation[i];
  const auto p = parameters(task.lens);
  std::array<Exact, 2> d;
  if (const auto* lens = std::get_if<Perspective>(&task.lens)) {
    d = distorted(lens->parameters(), x[0] / x[2], x[1] / x[2]);
  } else {
    const Exact r = std::sqrt(x[0] * x[0] + x[1] * x[1]), theta = std::atan2(r, x[2]);
    const Exact t = theta * theta;
    const Exact bent = theta * (1 + t * (p[4] + t * (p[5] + t * (p[6] + t * Exact(p[7])))));
    d = {bent * x[0] / r, bent * x[1] / r};
  }
  return {p[0] * d[0] + p[2], p[1] * d[1] + p[3]};
}

// RMS error of a coordinate, also as a multiple of that of the exact pixels rounded to doubles.
Verdict judge(const Pixels& pixels, const std::vector<std::array<Exact, 2>>& exact) {
  Exact error = 0, rounding = 0;
  for (std::size_t i = 0; i < exact.size(); ++i)
    for (std::size_t k = 0; k < 2; ++k) {
      const Exact e = pixels[i][static_cast<Eigen::Index>(k)] - exact[i][k];
      const Exact r = static_cast<double>(exact[i][k]) - exact[i][k];
      error += e * e, rounding += r * r;
    }
  const Exact n = 2 * static_cast<Exact>(exact.size());
  const double rms = static_cast<double>(std::sqrt(error / n));
  return {!(rms < 1e-3), rms, static_cast<double>(std::sqrt(error / rounding))};
}

ProjectMethod ours(const std::string& name, const ProjectKernels& kernels,
                   const std::string& settings) {
  struct State {
    ProjectTask task;
    Pose pose;
    Pixels pixels;
    std::vector<std::uint8_t> valid;
    std::vector<double> by_pose, by_parameters;
  };
  const auto prepare = [&kernels](const ProjectTask& task) {
    const std::size_t n = task.points.size();
    return prepare_state<Pixels>(
        State{task, Pose(exp_rotation(task.turn), task.translation), Pixels(n),
              std::vector<std::uint8_t>(n), std::vector<double>(task.free.empty() ? 0 : 12 * n),
              std::vector<double>(2 * task.free.size() * n)},
        [&kernels](State& s) {
          project_by(kernels, s.task.lens, s.pose, s.task.points, s.task.free,
                     {s.pixels, s.valid, s.by_pose, s.by_parameters});
        },
        &State::pixels);
  };
  return {name, prepare, settings};
}

struct OpenCvPoints {
  explicit OpenCvPoints(const ProjectTask& task)
      : turn(task.turn.x(), task.turn.y(), task.turn.z()),
        translation(task.translation.x(), task.translation.y(), task.translation.z()),
        fisheye(std::holds_alternative<Fisheye>(task.lens)),
        jacobians(!task.free.empty()) {
    const auto p = parameters(task.lens);
    k = cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    std::size_t used = p.size();  // without zeros at the end: 4, 5 or 8 coefficients
    while (used > 4 && p[used - 1] == 0) --used;
    if (used > 4)
      distortion = cv::Mat1d::zeros(1, used > 9 || fisheye ? static_cast<int>(p.size()) - 4 : 5);
    for (int i = 0; i < distortion.cols; ++i) distortion(i) = p[static_cast<std::size_t>(i) + 4];
    for (const Vector3d& x : task.points) points.emplace_back(x.x(), x.y(), x.z());
    pixels.resize(points.size());
  }

  void solve() {
    if (fisheye && jacobians)
      cv::fisheye::projectPoints(points, pixels, turn, translation, k, distortion, 0, jacobian);
    else if (fisheye)
      cv::fisheye::projectPoints(points, pixels, turn, translation, k, distortion);
    else if (jacobians)
      cv::projectPoints(points, turn, translation, k, distortion, pixels, jacobian);
    else
      cv::projectPoints(points, turn, translation, k, distortion, pixels);
  }

  Pixels answer() const {
    Pixels result;
    for (const cv::Point2d& p : pixels) result.emplace_back(p.x, p.y);
    return result;
  }

  cv::Vec3d turn, translation;
  bool fisheye, jacobians;
  cv::Matx33d k;
  cv::Mat1d distortion;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;
};

ProjectMethod opencv(bool fisheye) {
  return {fisheye ? "OpenCV fisheye::projectPoints" : "OpenCV projectPoints",
          [](const ProjectTask& task) {
            return prepare_state<Pixels>(OpenCvPoints(task), &OpenCvPoints::solve,
                                         &OpenCvPoints::answer);
          },
          "double precision, arrays allocated before"};
}

std::vector<Attempt> draw(const Cell& cell, const std::vector<ProjectMethod>& methods,
                          Random& random) {
  const ProjectTask task = draw_points(cell, random);
  auto exact = std::make_shared<std::vector<std::array<Exact, 2>>>();
  for (const Vector3d& point : task.points) exact->push_back(exact_pixel(task, point));
  return attempts_of(methods, task,
                     [exact](const Pixels& pixels) { return judge(pixels, *exact); });
}

void add_panel(const Cell& cell, ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {
      "", cell.jacobians ? "pixels and Jacobians" : "pixels", std::string(cell.model), {}};
  std::vector<ProjectMethod> methods = {
      ours("tagcal project", fastest_kernels(), "the fastest instructions of this processor")};
  if (&fastest_kernels() != &kPortableKernels)
    methods.push_back(ours("tagcal project, portable", kPortableKernels, "for any processor"));
  methods.push_back(opencv(std::holds_alternative<Fisheye>(cell.lens)));
  panel.methods = study.numbers_of(methods);
  panel.draw = [cell, methods](Random& random) { return draw(cell, methods, random); };
  study.panels.push_back(std::move(panel));
}

}  // namespace

ChartStudy project_study() {
  ChartStudy study;
  study.error_unit = "pixels, a coordinate (of 1000 points a call)";
  study.bound_name = "rounding of the exact pixel to a double";
  study.failure = "pixels off by more than 0.001";
  study.trials = 400;
  study.quick_trials = 50;
  for (const bool jacobians : {false, true}) {
    add_panel({pinhole(800, 810, 640, 400), "pinhole", jacobians}, study);
    add_panel(
        {Perspective({800, 810, 640, 400, -0.28, 0.07, 1e-3, -5e-4, 2e-3}), "opencv5", jacobians},
        study);
    add_panel({Perspective({800, 810, 640, 400, 0.2, -0.1, 1e-3, -5e-4, 2e-3, 0.35, 0.05, 0.01}),
               "opencv8", jacobians},
              study);
    add_panel({Fisheye({400, 405, 640, 400, -0.01, 0.02, -0.01, 0.002}), "fisheye4", jacobians},
              study);
  }
  return study;
}

}  // namespace tagcal::study
