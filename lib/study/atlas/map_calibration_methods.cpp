// The methods of the maps of calibration.

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "study/atlas/map_calibration.hpp"
#include "study/peers/opencv_views.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::study {
namespace {

// Returns true for a finding that the lens or the board may not be as stated.
bool is_doubt(const Finding& finding, JudgedLens judged) {
  constexpr std::array kDoubts = {code::halves_disagree.name,
                                  code::board_bend_impossible.name,
                                  code::residuals_biased.name,
                                  code::model_too_small.name,
                                  code::other_lens.name,
                                  code::tags_misplaced.name,
                                  code::principal_point_untested.name};
  if (judged == JudgedLens::image_corners && finding.code == code::extrapolated.name) return true;
  return std::ranges::find(kDoubts, finding.code) != kDoubts.end();
}

LensAnswer answer_of(const Calibration& found, JudgedLens judged) {
  LensAnswer answer;
  answer.said = status_name(found.status);
  answer.success = is_answer(found.status);
  if (!answer.success) return answer;
  answer.doubted = std::any_of(found.findings.begin(), found.findings.end(),
                               [&](const Finding& f) { return is_doubt(f, judged); });
  if (answer.doubted) answer.said += "+doubt";
  answer.claim = uncertain_camera(found);
  return answer;
}

// `model`: empty for the true model.
struct OurCall {
  std::string model;
  bool noise_stated = true;
};

CalibrationSolver ours(const std::string& name, const std::string& settings, const OurCall& call) {
  CalibrationSolver solver{name, settings, true};
  solver.prepare = [call](const CalibrationQuestion& question) {
    return prepare_task<LensAnswer>(
        question,
        [call](const CalibrationQuestion& q) {
          CalibrateOptions options;
          options.model = call.model.empty() ? q.good.model : call.model;
          if (call.noise_stated) options.sigma_px = q.good.sigma_px;
          return calibrate(q.dataset, options);
        },
        [judged = question.judged](const Calibration& found) { return answer_of(found, judged); });
  };
  return solver;
}

bool finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

LensAnswer lens_answer(const std::string& model, const std::vector<double>& free,
                       const ImageSize& size) {
  LensAnswer answer;
  answer.said = "no answer";
  if (!finite(free)) return answer;
  const auto lens = Model::named(model).lens(free, size);
  if (!lens) return answer;
  answer.success = true;
  answer.said = "answer";
  answer.claim = {&Model::named(model), {*lens, size}, {}};
  return answer;
}

// The answer with its standard deviations; none if one of them is not finite.
LensAnswer camera_answer(const OpenCvViews& state, const std::string& model) {
  const auto n = static_cast<std::size_t>(Model::named(model).num_free());
  std::vector<double> free = state.values();
  free.resize(n);
  LensAnswer answer = lens_answer(model, free, {state.size.width, state.size.height});
  Eigen::VectorXd sigmas(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i)
    sigmas[static_cast<Eigen::Index>(i)] = state.deviations.at<double>(static_cast<int>(i));
  if (!sigmas.allFinite()) {
    answer.success = false;
    answer.said = "no deviations";
  }
  answer.claim.covariance = sigmas.cwiseAbs2().asDiagonal();
  return answer;
}

CalibrationSolver calibrate_camera(const std::string& name, const std::string& settings,
                                   const std::string& model, int flags) {
  CalibrationSolver solver{name, settings, false, "perspective"};
  solver.prepare = [model, flags](const CalibrationQuestion& question) {
    return prepare_state<LensAnswer>(
        OpenCvViews(question.dataset), [flags](OpenCvViews& views) { views.calibrate(flags); },
        [model](const OpenCvViews& v) { return camera_answer(v, model); });
  };
  return solver;
}

CalibrationSolver mrcal_solver() {
  CalibrationSolver solver{
      "mrcal",
      "LENSMODEL_OPENCV5 in the three stages of its tool, the true f given, poses by solvePnP; no "
      "uncertainties, so that it is held to the Cramér-Rao bound",
      false, "perspective"};
  solver.prepare = [](const CalibrationQuestion& question) {
    return prepare_task<LensAnswer>(
        question,
        [](const CalibrationQuestion& q) {
          return calibrate_by_mrcal(q.dataset, parameters(q.good.lens)[0]);
        },
        [size = question.dataset.image_size](const std::vector<double>& found) {
          return lens_answer("opencv5", found, size);
        });
  };
  return solver;
}

}  // namespace

CalibrationSolver our_calibration() {
  return ours("tagcal calibrate", "the model by itself (auto), sigma_px not given; one thread",
              {"auto", false});
}

CalibrationSolver our_calibration_by_name() {
  return ours("tagcal calibrate, by name", "the model of the truth by its name, sigma_px given",
              {});
}

CalibrationSolver our_calibration_by_name(const std::string& model) {
  CalibrationSolver solver =
      ours("tagcal calibrate, " + model, model + " by its name, sigma_px given", {model});
  solver.lens = model == "fisheye4" ? "fisheye" : "perspective";
  return solver;
}

CalibrationSolver opencv_calibration() {
  return calibrate_camera("OpenCV calibrateCamera",
                          "default flags (five coefficients), with its standard deviations",
                          "opencv5", 0);
}

CalibrationSolver opencv_calibration_of(const std::string& model) {
  int flags = cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K3;
  if (model == "pinhole") flags |= cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2;
  return calibrate_camera(
      "OpenCV calibrateCamera, " + model,
      "coefficients that the lens does not have are fixed, as advised; with standard deviations",
      model == "pinhole" ? "pinhole" : "opencv5", flags);
}

CalibrationSolver opencv_fisheye() {
  CalibrationSolver solver{
      "OpenCV fisheye::calibrate",
      "CALIB_RECOMPUTE_EXTRINSIC | CALIB_FIX_SKEW; no standard deviations, so that it is held to "
      "the Cramér-Rao bound",
      false, "fisheye"};
  solver.prepare = [](const CalibrationQuestion& question) {
    return prepare_state<LensAnswer>(
        OpenCvViews(question.dataset), &OpenCvViews::calibrate_fisheye, [](const OpenCvViews& v) {
          return lens_answer("fisheye4", v.values(), {v.size.width, v.size.height});
        });
  };
  return solver;
}

std::vector<CalibrationSolver> with_mrcal(std::vector<CalibrationSolver> solvers) {
  if (has_mrcal()) solvers.push_back(mrcal_solver());
  return solvers;
}

}  // namespace tagcal::study
