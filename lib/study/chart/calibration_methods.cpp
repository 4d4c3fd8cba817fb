#include <memory>
#include <opencv2/calib3d.hpp>

#include "study/peers/ceres_peer.hpp"
#include "study/peers/opencv_views.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::study {
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

template <typename Solve>
CalibrationMethod opencv_method(const std::string& name, const std::string& settings, Solve solve) {
  return {name,
          [solve](const CalibrationTask& task) -> Prepared<CalibrationAnswer> {
            struct State {
              OpenCvViews views;
              CalibrationAnswer found;
            };
            auto state = std::make_shared<State>(State{OpenCvViews(task.dataset), {}});
            return {[state, solve] {
                      state->found.clear();
                      state->views.k = cv::Mat();
                      state->views.distortion = cv::Mat();
                      solve(state->views);  // what it throws is a failure
                      state->found = state->views.values();
                    },
                    [state] { return state->found; }};
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

struct MrcalState {
  CalibrationTask task;
  MrcalStages stages;
  MrcalProblem problem{};
  std::array<double, 9> found{};

  void pose_views() { problem = mrcal_problem(task.dataset, parameters(task.lens)[0]); }
  void solve() {
    if (stages == MrcalStages::three) pose_views();
    found = mrcal_intrinsics(problem, stages);
  }
};

}  // namespace

CalibrationMethod mrcal_calibration(MrcalStages stages) {
  return {stages == MrcalStages::three ? "mrcal" : "mrcal, its optimiser",
          [stages](const CalibrationTask& task) -> Prepared<CalibrationAnswer> {
            auto state = std::make_shared<MrcalState>(MrcalState{task, stages});
            if (stages == MrcalStages::one) state->pose_views();
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
  methods.push_back(ceres_autodiff_calibration());
  if (has_mrcal()) methods.push_back(mrcal_calibration(MrcalStages::three));
  return methods;
}

}  // namespace tagcal::study
