// How the methods of the maps of calibration are called.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "study/atlas/map_calibration.hpp"
#include "study/peers/opencv_views.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::study {
namespace {

// Warnings that what was stated does not hold, and what an answer is worth then.
bool is_doubt(const std::string& warning, JudgedLens judged) {
  constexpr std::array<std::string_view, 7> kDoubts = {"two halves of the views",
                                                       "bent board",
                                                       "board bent by",
                                                       "the residuals differ from place to place",
                                                       "the model is too small",
                                                       "the target is not as its file says",
                                                       "the principal point is taken to be"};
  if (judged == JudgedLens::image_corners &&
      warning.find("the lens is extrapolated there") != std::string::npos)
    return true;
  return std::any_of(kDoubts.begin(), kDoubts.end(), [&](std::string_view text) {
    return warning.find(text) != std::string::npos;
  });
}

LensAnswer answer_of(const Calibration& found, JudgedLens judged) {
  LensAnswer answer;
  answer.said = status_name(found.status);
  answer.success = is_answer(found.status);
  if (!answer.success) return answer;
  answer.doubted = std::any_of(found.warnings.begin(), found.warnings.end(),
                               [&](const std::string& w) { return is_doubt(w, judged); });
  if (answer.doubted) answer.said += "+doubt";
  answer.lens = found.camera->lens;
  answer.model = found.model;
  answer.covariance = found.covariance;
  return answer;
}

// `model`: empty for that of the truth.
struct OurCall {
  std::string model;
  bool noise_stated = true, bend = false;
};

CalibrationSolver ours(const std::string& name, const std::string& settings, const OurCall& call) {
  CalibrationSolver solver{name, settings, true};
  solver.prepare = [call](const CalibrationQuestion& question) -> Prepared<LensAnswer> {
    struct State {
      CalibrationQuestion question;
      Calibration found;
    };
    auto state = std::make_shared<State>(State{question, {}});
    return {[state, call] {
              CalibrateOptions options;
              options.model = call.model.empty() ? state->question.good.model : call.model;
              options.board_warp = call.bend;
              if (call.noise_stated) options.sigma_px = state->question.good.sigma_px;
              state->found = calibrate(state->question.dataset, options);
            },
            [state] { return answer_of(state->found, state->question.judged); }};
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
  answer.lens = *lens;
  answer.model = model;
  return answer;
}

// With its standard deviations; some that are no numbers are no answer.
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
  answer.covariance = sigmas.cwiseAbs2().asDiagonal();
  return answer;
}

CalibrationSolver calibrate_camera(const std::string& name, const std::string& settings,
                                   const std::string& model, int flags) {
  CalibrationSolver solver{name, settings, false, "perspective"};
  solver.prepare = [model, flags](const CalibrationQuestion& q) -> Prepared<LensAnswer> {
    auto state = std::make_shared<OpenCvViews>(q.dataset);
    return {[state, flags] {
              cv::calibrateCamera(state->points, state->pixels, state->size, state->k,
                                  state->distortion, state->turns, state->moves, state->deviations,
                                  cv::noArray(), cv::noArray(), flags);
            },
            [state, model] { return camera_answer(*state, model); }};
  };
  return solver;
}

CalibrationSolver mrcal_solver() {
  CalibrationSolver solver{
      "mrcal",
      "LENSMODEL_OPENCV5 in the three stages of its tool, the true f given, poses by solvePnP; no "
      "uncertainties, so that it is held to the Cramér-Rao bound",
      false, "perspective"};
  solver.prepare = [](const CalibrationQuestion& question) -> Prepared<LensAnswer> {
    struct State {
      CalibrationQuestion question;
      std::array<double, 9> found{};
    };
    auto state = std::make_shared<State>(State{question});
    return {[state] {
              const double focal_px = parameters(state->question.good.lens)[0];
              state->found = mrcal_intrinsics(mrcal_problem(state->question.dataset, focal_px),
                                              MrcalStages::three);
            },
            [state] {
              return lens_answer("opencv5", {state->found.begin(), state->found.end()},
                                 state->question.dataset.image_size);
            }};
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

CalibrationSolver our_calibration_with_bend() {
  return ours("tagcal calibrate, board warp",
              "the model of the truth by its name, sigma_px given, board_warp", {"", true, true});
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
  solver.prepare = [](const CalibrationQuestion& question) -> Prepared<LensAnswer> {
    auto state = std::make_shared<OpenCvViews>(question.dataset);
    return {
        [state] {
          cv::fisheye::calibrate(
              state->points, state->pixels, state->size, state->k, state->distortion, state->turns,
              state->moves, cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
        },
        [state] {
          return lens_answer("fisheye4", state->values(), {state->size.width, state->size.height});
        }};
  };
  return solver;
}

std::vector<CalibrationSolver> with_mrcal(std::vector<CalibrationSolver> solvers) {
  if (has_mrcal()) solvers.push_back(mrcal_solver());
  return solvers;
}

}  // namespace tagcal::study
