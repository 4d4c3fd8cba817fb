// The job `calibrate` of the chart.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "study/chart/chart_study.hpp"
#include "study/peers/mrcal_peer.hpp"
#include "study/peers/opencv_views.hpp"
#include "study/peers/pose_peers.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::study {
namespace {

struct Cell {
  Lens lens;
  std::string model;
  int num_views;
};

constexpr double kGrossFocalShare = 0.1;

struct Truth {
  std::vector<double> parameters;
  Eigen::MatrixXd information;

  Verdict judge(const CalibrationAnswer& answer) const {
    if (answer.size() != parameters.size()) return {};
    const auto n = static_cast<Eigen::Index>(parameters.size());
    const Eigen::VectorXd e = Eigen::Map<const Eigen::VectorXd>(answer.data(), n) -
                              Eigen::Map<const Eigen::VectorXd>(parameters.data(), n);
    return {!(std::abs(e[0]) < kGrossFocalShare * parameters[0]), std::abs(e[0]),
            std::sqrt(e.dot(information * e) / static_cast<double>(n))};
  }
};

std::vector<Attempt> draw(const Cell& cell, const std::vector<CalibrationMethod>& methods,
                          Random& random) {
  const CalibrationTask task = draw_calibration(cell.lens, cell.model, cell.num_views, random);
  auto truth = std::make_shared<Truth>();
  truth->parameters = Model::named(cell.model).free_values(cell.lens);
  truth->information = calibration_information(task);
  return attempts_of(methods, task,
                     [truth](const CalibrationAnswer& answer) { return truth->judge(answer); });
}

void add_panel(const Cell& cell, ChartStudy& study) {
  StudyPanel panel;
  const bool fisheye = std::holds_alternative<Fisheye>(cell.lens);
  panel.panel = {"", fisheye ? "fisheye4" : "opencv5", fmt::format("{} views", cell.num_views), {}};
  if (fisheye) panel.panel.cannot.emplace_back("mrcal: has no lens of Kannala and Brandt");
  if (!fisheye && !has_mrcal())
    panel.panel.cannot.emplace_back("mrcal: not there when this was built");
  const auto methods = calibration_methods(cell.model);
  panel.methods = study.numbers_of(methods);
  panel.draw = [cell, methods](Random& random) { return draw(cell, methods, random); };
  study.panels.push_back(std::move(panel));
}

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

ChartStudy calibrate_study(bool quick) {
  ChartStudy study;
  study.error_unit = "fx, pixels";
  study.bound_name = "Cramér-Rao bound";
  study.failure = "no answer, or fx off by more than 10 %";
  study.trials = 100;
  study.quick_trials = 12;
  const Lens brown = Perspective({900, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0});
  const Lens fisheye = Fisheye({420, 419, 633, 405, 0.02, -0.01, 0.003, -0.0005});
  for (const int views : quick ? std::vector<int>{5, 10, 20} : std::vector<int>{5, 20, 50}) {
    add_panel({brown, "opencv5", views}, study);
    add_panel({fisheye, "fisheye4", views}, study);
  }
  return study;
}

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
