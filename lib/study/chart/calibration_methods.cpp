#include <opencv2/calib3d.hpp>

#include "study/peers/opencv_views.hpp"
#include "study/peers/pose_peers.hpp"
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
            return prepare_state<CalibrationAnswer>(OpenCvViews(task.dataset), solve,
                                                    &OpenCvViews::values);
          },
          settings};
}

CalibrationMethod calibrate_camera(const std::string& name, int flags) {
  return opencv_method(name,
                       flags == 0 ? "default flags, with standard deviations"
                                  : "CALIB_USE_LU, with standard deviations",
                       [flags](OpenCvViews& views) { views.calibrate(flags); });
}

CalibrationMethod mrcal_calibration() {
  const auto prepare = [](const CalibrationTask& task) {
    return prepare_task<CalibrationAnswer>(task, [](const CalibrationTask& t) {
      return calibrate_by_mrcal(t.dataset, parameters(t.lens)[0]);
    });
  };
  return {"mrcal", prepare,
          "LENSMODEL_OPENCV5 in the three stages of its tool, the true f given, poses by solvePnP; "
          "no outliers looked for, no regularisation, no uncertainties"};
}

}  // namespace

std::vector<CalibrationMethod> calibration_methods(const std::string& model) {
  std::vector<CalibrationMethod> methods = {
      {"tagcal calibrate", prepare_ours,
       "the model by its name, sigma_px given, wrong corners looked for, with covariance and all "
       "that is said of it; one thread"}};
  if (model == "fisheye4") {
    methods.push_back(opencv_method(
        "OpenCV fisheye::calibrate",
        "CALIB_RECOMPUTE_EXTRINSIC | CALIB_FIX_SKEW, 100 iterations; no standard deviations",
        &OpenCvViews::calibrate_fisheye));
    return methods;
  }
  methods.push_back(calibrate_camera("OpenCV calibrateCamera", 0));
  methods.push_back(calibrate_camera("OpenCV calibrateCamera, LU", cv::CALIB_USE_LU));
  methods.push_back(ceres_autodiff_calibration());
  if (has_mrcal()) methods.push_back(mrcal_calibration());
  return methods;
}

}  // namespace tagcal::study
