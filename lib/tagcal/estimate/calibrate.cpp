#include "tagcal/estimate/calibrate.hpp"

#include <chrono>

#include "tagcal/error.hpp"
#include "tagcal/estimate/observability.hpp"
#include "tagcal/estimate/result.hpp"
#include "tagcal/estimate/selection.hpp"
#include "tagcal/estimate/wrong_views.hpp"

namespace tagcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFocalCertain = 0.002;  // sd(f) / f

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Calibration without_answer(const CalibrationInput& input, const std::string& model) {
  Calibration c;
  c.model = model;
  c.warnings = input.warnings;
  const bool any = !input.views.empty();
  c.status = any || !input.dropped.empty() ? Status::no_consensus : Status::degenerate;
  if (any)
    c.warnings.emplace_back("in no view do the corners agree on a pose");
  else if (input.dropped.empty())
    c.warnings.emplace_back("no view has four corners that are not on a line");
  return c;
}

// What looked like an answer is none; nor is what it says of itself.
void withdraw(Calibration& c, Status status, const std::string& reason) {
  c.status = status;
  c.warnings.push_back(reason);
  c.projection.clear();
  c.halves.reset();
  c.board_warp.reset();
}

bool is_weak(const Model& model) { return model.lens_type() == LensType::parallel; }

Calibration calibrate_weak(const CalibrationInput& input, const CalibrateOptions& options) {
  const std::optional<WeakFit> weak = fit_weak(input, options);
  if (!weak) return without_answer(input, "weak");
  return report_weak(*weak, options);
}

constexpr int kMostRounds = 4;  // of leaving out what stands out

// A large lens bends to a wrong view, so that this no longer stands out: a smaller one is asked,
// too, wherever a large one was chosen or more than a few corners were rejected.
bool leave_out_of_choice(CalibrationInput& input, const CalibrationFit& chosen,
                         const CalibrateOptions& options) {
  if (leave_out_what_stands_out(input, chosen, options)) return true;
  const Model& usual = Model::named("opencv5");
  const bool large = chosen.bundle.model->num_free() > usual.num_free() ||
                     chosen.bundle.model->lens_type() == LensType::fisheye;
  if (!large && 50 * chosen.num_inliers() > 49 * chosen.num_corners) return false;
  const std::optional<CalibrationFit> fit = fit_model(usual, input, options);
  return fit && leave_out_what_stands_out(input, *fit, options);
}

Calibration calibrate_auto(CalibrationInput& input, const CalibrateOptions& options,
                           const FlatBoard* board) {
  std::optional<ModelChoice> choice = choose_model(input, options);
  for (int round = 0; choice && options.reject_outliers && round < kMostRounds; ++round) {
    if (!leave_out_of_choice(input, choice->fit, options)) break;
    choice = choose_model(input, options);
  }
  if (!choice) return without_answer(input, "");
  Calibration c =
      choice->weak ? calibrate_weak(input, options) : report(choice->fit, options, board);
  if (is_answer(c.status) && choice->status != Status::ok) {
    withdraw(c, choice->status, choice->reason);
  }
  c.steps = choice->steps;
  c.bic = choice->fit.bic;
  return c;
}

bool well_in_front(const Bundle& bundle) {
  constexpr double kSmallestCosine = 0.17;  // 80 degrees from the axis
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    for (const Correspondence& c : bundle.views[v].correspondences) {
      const Eigen::Vector3d x = bundle.camera_from_target[v] * c.point;
      if (x.z() < kSmallestCosine * x.norm()) return false;
    }
  }
  return true;
}

// Many free coefficients can talk the information into a focal length that the same data do not
// hold without them: where it is not known to 0.2 %, the plain pinhole is asked, too (of a fisheye
// as far as all corners lie well in front).
void doubt_focal_length(Calibration& c, const CalibrationFit& fit) {
  const Model& model = *fit.bundle.model;
  if (!is_answer(c.status) || model.num_free() == 1) return;
  const double focal = parameters(c.camera->lens)[0];
  if (c.sigmas[0] < kFocalCertain * focal) return;
  Bundle plain = fit.bundle;
  plain.model = &Model::named("f");
  plain.free_values = {focal};
  if (!well_in_front(plain)) return;
  solve(plain, 100);
  const Observability seen = observability(plain, c.sigma_px);
  if (seen.status != Status::focal_not_observable) return;
  withdraw(c, seen.status, seen.reason);
}

Calibration calibrate_model(const Model& model, CalibrationInput& input,
                            const CalibrateOptions& options, const FlatBoard* board) {
  if (is_weak(model)) return calibrate_weak(input, options);
  std::optional<CalibrationFit> fit = fit_model(model, input, options);
  for (int round = 0; fit && options.reject_outliers && round < kMostRounds; ++round) {
    if (!leave_out_what_stands_out(input, *fit, options)) break;
    fit = fit_model(model, input, options);
  }
  if (!fit) return without_answer(input, std::string(model.name()));
  Calibration c = report(*fit, options, board);
  doubt_focal_length(c, *fit);
  return c;
}

bool is_auto(const CalibrateOptions& options) {
  return options.model.empty() || options.model == "auto";
}

}  // namespace

void check_options(const CalibrateOptions& options) {
  if (!is_auto(options) && is_weak(Model::named(options.model)) && options.board_warp)
    throw Error("board_warp: model weak holds no perspective that would show a bent board");
  for (const double distance : options.distances_m)
    if (!(distance > 0)) throw Error("distances_m: must be > 0, got " + std::to_string(distance));
}

Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options) {
  const auto begin = Clock::now();
  check_options(options);
  const std::optional<FlatBoard> board = flat_board(dataset);
  if (options.board_warp && !board) throw Error("board_warp: needs one board, and a flat one");
  CalibrationInput input = calibration_input(dataset, options.sigma_px > 0);
  const FlatBoard* flat = board ? &*board : nullptr;
  const Eigen::Vector2d bent_m =
      options.board_warp ? unbend(input, *board, options) : Eigen::Vector2d(0, 0);
  Calibration result = is_auto(options)
                           ? calibrate_auto(input, options, flat)
                           : calibrate_model(Model::named(options.model), input, options, flat);
  if (result.board_warp) result.board_warp->bend_mm += 1e3 * bent_m;
  result.outliers.insert(result.outliers.end(), input.dropped.begin(), input.dropped.end());
  result.seconds.total = seconds_since(begin);
  return result;
}

}  // namespace tagcal
