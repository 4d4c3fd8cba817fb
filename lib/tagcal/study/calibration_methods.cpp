#include <memory>
#include <opencv2/calib3d.hpp>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/study/calibration_tasks.hpp"

namespace tagcal {
namespace {

Prepared<CalibrationAnswer> prepare_ours(const CalibrationTask& task) {
  struct State {
    CalibrationTask task;
    Calibration found;
  };
  auto state = std::make_shared<State>(State{task, {}});
  return {[state] {
            CalibrateOptions options;
            options.model = state->task.model;
            options.sigma_px = state->task.sigma_px;
            state->found = calibrate(state->task.dataset, options);
          },
          [state]() -> CalibrationAnswer {
            if (!is_answer(state->found.status)) return {};
            return Model::named(state->task.model).free_values(state->found.camera->lens);
          }};
}

struct OpenCvViews {
  explicit OpenCvViews(const CalibrationTask& task)
      : size(task.dataset.image_size.width, task.dataset.image_size.height) {
    const std::vector<TargetPoint>& board = task.dataset.boards[0].board.points;
    for (const View& view : task.dataset.views) {
      points.emplace_back();
      pixels.emplace_back();
      for (const Observation& o : view.observations) {
        const Eigen::Vector3f x =
            board[static_cast<std::size_t>(o.id.tag_id)].position.cast<float>();
        const Eigen::Vector2f u = o.pixel.cast<float>();
        points.back().emplace_back(x.x(), x.y(), x.z());
        pixels.back().emplace_back(u.x(), u.y());
      }
    }
  }

  // fx fy cx cy and the coefficients.
  CalibrationAnswer answer() const {
    if (!success) return {};
    CalibrationAnswer all = {k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2),
                             k.at<double>(1, 2)};
    for (int i = 0; i < static_cast<int>(distortion.total()); ++i)
      all.push_back(distortion.at<double>(i));
    return all;
  }

  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  cv::Size size;
  cv::Mat k, distortion, deviations;
  std::vector<cv::Mat> turns, moves;
  bool success = false;
};

template <typename Solve>
CalibrationMethod opencv_method(const std::string& name, const std::string& settings, Solve solve) {
  return {name,
          [solve](const CalibrationTask& task) -> Prepared<CalibrationAnswer> {
            auto views = std::make_shared<OpenCvViews>(task);
            return {[views, solve] {
                      views->k = cv::Mat();
                      views->distortion = cv::Mat();
                      views->success = false;
                      solve(*views);  // what it throws is a failure
                      views->success = true;
                    },
                    [views] { return views->answer(); }};
          },
          settings};
}

CalibrationMethod calibrate_camera(const std::string& name, int flags) {
  return opencv_method(name,
                       flags == 0 ? "default flags, with standard deviations"
                                  : "CALIB_USE_LU, with standard deviations",
                       [flags](OpenCvViews& v) {
                         cv::calibrateCamera(v.points, v.pixels, v.size, v.k, v.distortion, v.turns,
                                             v.moves, v.deviations, cv::noArray(), cv::noArray(),
                                             flags);
                       });
}

CalibrationMethod fisheye_calibrate() {
  return opencv_method(
      "OpenCV fisheye::calibrate",
      "CALIB_RECOMPUTE_EXTRINSIC | CALIB_FIX_SKEW, 100 iterations; no standard deviations",
      [](OpenCvViews& v) {
        cv::fisheye::calibrate(
            v.points, v.pixels, v.size, v.k, v.distortion, v.turns, v.moves,
            cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
      });
}

// Poses by cv::solvePnP of a pinhole with the true focal length.
MrcalProblem mrcal_problem(const CalibrationTask& task, const OpenCvViews& views) {
  const double focal_px = parameters(task.lens)[0];
  MrcalProblem problem{views.size.width, views.size.height, kGridPoints, kGridPoints,
                       kGridSpacingM,    focal_px,          {},          {}};
  const cv::Matx33d k(focal_px, 0, 0.5 * (views.size.width - 1), 0, focal_px,
                      0.5 * (views.size.height - 1), 0, 0, 1);
  for (std::size_t v = 0; v < views.points.size(); ++v) {
    std::vector<double> pixels;
    for (int i = 0; i < kGridPoints * kGridPoints; ++i) pixels.insert(pixels.end(), {0, 0, -1});
    for (const Observation& o : task.dataset.views[v].observations) {
      double* corner = &pixels[static_cast<std::size_t>(3 * o.id.tag_id)];
      corner[0] = o.pixel.x(), corner[1] = o.pixel.y(), corner[2] = 1;
    }
    problem.pixels.insert(problem.pixels.end(), pixels.begin(), pixels.end());
    cv::Vec3d turn, move;
    cv::solvePnP(views.points[v], views.pixels[v], k, cv::noArray(), turn, move);
    problem.poses.insert(problem.poses.end(),
                         {turn[0], turn[1], turn[2], move[0], move[1], move[2]});
  }
  return problem;
}

struct MrcalState {
  CalibrationTask task;
  OpenCvViews views;
  MrcalStages stages;
  MrcalProblem problem{};
  std::array<double, 9> found{};

  void solve() {
    if (stages == MrcalStages::three) problem = mrcal_problem(task, views);
    found = mrcal_intrinsics(problem, stages);
  }
};

}  // namespace

CalibrationMethod mrcal_calibration(MrcalStages stages) {
  return {stages == MrcalStages::three ? "mrcal" : "mrcal, its optimiser",
          [stages](const CalibrationTask& task) -> Prepared<CalibrationAnswer> {
            auto state = std::make_shared<MrcalState>(MrcalState{task, OpenCvViews(task), stages});
            if (stages == MrcalStages::one) state->problem = mrcal_problem(task, state->views);
            return {
                [state] { state->solve(); },
                [state] { return CalibrationAnswer(state->found.begin(), state->found.end()); }};
          },
          "LENSMODEL_OPENCV5 in the three stages of its tool, the true f given, poses by solvePnP; "
          "no outliers looked for, no regularisation, no uncertainties"};
}

std::vector<CalibrationMethod> calibration_methods(const std::string& model) {
  std::vector<CalibrationMethod> methods = {
      {"tagcal calibrate", prepare_ours,
       "the model by its name, sigma_px given, wrong corners looked for, with covariance and all "
       "that is said of it; one thread"}};
  if (model == "fisheye4") {
    methods.push_back(fisheye_calibrate());
    return methods;
  }
  methods.push_back(calibrate_camera("OpenCV calibrateCamera", 0));
  methods.push_back(calibrate_camera("OpenCV calibrateCamera, LU", cv::CALIB_USE_LU));
  if (has_mrcal()) methods.push_back(mrcal_calibration(MrcalStages::three));
  return methods;
}

}  // namespace tagcal
