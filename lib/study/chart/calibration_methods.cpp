#include <opencv2/calib3d.hpp>

#include "study/peers/ceres_peer.hpp"
#include "study/peers/opencv_views.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::study {
namespace {

Prepared<CalibrationAnswer> prepare_ours(const CalibrationTask& task) {
  return prepare_task<CalibrationAnswer>(
      task,
      [](const CalibrationTask& t) {
        CalibrateOptions options;
        options.model = t.model;
        options.sigma_px = t.sigma_px;
        return calibrate(t.dataset, options);
      },
      [model = task.model](const Calibration& found) -> CalibrationAnswer {
        if (!is_answer(found.status)) return {};
        return Model::named(model).free_values(found.camera->lens);
      });
}

// An exception of `solve` is a failure of the method.
template <typename Solve>
CalibrationMethod opencv_method(const std::string& name, const std::string& settings, Solve solve) {
  return {name,
          [solve](const CalibrationTask& task) {
            return prepare_task<CalibrationAnswer>(OpenCvViews(task.dataset),
                                                   [solve](OpenCvViews& views) {
                                                     views.k = cv::Mat();
                                                     views.distortion = cv::Mat();
                                                     solve(views);
                                                     return views.values();
                                                   });
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

}  // namespace

CalibrationMethod mrcal_calibration(MrcalStages stages) {
  const auto prepare = [stages](const CalibrationTask& task) {
    const auto posed = [](const CalibrationTask& t) {
      return mrcal_problem(t.dataset, parameters(t.lens)[0]);
    };
    const auto answer = [](const std::array<double, 9>& found) {
      return CalibrationAnswer(found.begin(), found.end());
    };
    if (stages == MrcalStages::one)
      return prepare_task<CalibrationAnswer>(
          posed(task), [](const MrcalProblem& p) { return mrcal_intrinsics(p, MrcalStages::one); },
          answer);
    return prepare_task<CalibrationAnswer>(
        task,
        [posed](const CalibrationTask& t) {
          return mrcal_intrinsics(posed(t), MrcalStages::three);
        },
        answer);
  };
  return {stages == MrcalStages::three ? "mrcal" : "mrcal, its optimiser", prepare,
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
