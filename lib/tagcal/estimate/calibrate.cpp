#include "tagcal/estimate/calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/model_choice.hpp"
#include "tagcal/estimate/calibration/model_error.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/view_rejection.hpp"
#include "tagcal/estimate/checks/checks.hpp"
#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/checks/report.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The result if there is no fit.
Calibration no_answer(const CalibrationInput& input, std::string_view model) {
  Calibration c;
  c.model = model;
  c.findings = input.findings;
  if (!input.views.empty() || !input.rejected.empty())
    add(c.findings, code::no_consensus,
        "the corners of no view are consistent with one pose: check that the target file describes "
        "the board, and the ids of the tags");
  else
    add(c.findings, code::degenerate,
        "no view has four corners that are not on one line: no pose can be determined");
  c.status = judge(c.findings);
  return c;
}

bool is_weak(const Model& model) { return model.lens_type() == LensType::parallel; }

// `refusal`: of a model with perspective, or none.
Calibration calibrate_weak(const CalibrationInput& input, const CalibrateOptions& options,
                           std::optional<Finding> refusal = {}) {
  const std::optional<WeakFit> weak = fit_weak(input, options);
  if (!weak) return no_answer(input, "weak");
  return report_weak(*weak, options, std::move(refusal));
}

// Fits the model that the user named, or chooses one.
std::optional<ModelChoice> fit_or_choose(const CalibrationInput& input,
                                         const CalibrateOptions& options) {
  if (is_auto(options)) return choose_model(input, options);
  std::optional<CalibrationFit> fit = fit_model(input.models->named(options.model), input, options);
  if (!fit) return std::nullopt;
  return ModelChoice{std::move(*fit), false, Status::ok, "", {}, {}};
}

// Fits, estimates the error of lens and target, and rejects outlying views, until nothing changes.
// Sets the trial of the other kind of lens that the fit needs before views are rejected.
std::optional<ModelChoice> fit_robustly(CalibrationInput& input, const CalibrateOptions& options,
                                        std::optional<AlternativeLens>& alternative) {
  constexpr int kRounds = 10;  // a limit of work
  // Views are judged by the best model: the misfit of a smaller one that a tolerance allows is no
  // reason to reject them.
  CalibrateOptions best = options;
  best.tolerance_px = 0;
  std::optional<ModelChoice> solved = fit_or_choose(input, best);
  for (int round = 0; solved && round < kRounds; ++round) {
    // The residuals of a refused model are no estimate of that error.
    const bool is_error_changed =
        solved->status == Status::ok && update_model_error(input, solved->fit);
    if (!is_error_changed && !is_auto(options) && !alternative)
      alternative = alternative_lens(solved->fit, input);
    const bool is_rejected = !is_error_changed && options.reject_outliers &&
                             reject_outlying_views(input, solved->fit, best);
    if (!is_error_changed && !is_rejected) break;
    solved = fit_or_choose(input, best);
  }
  if (solved && options.tolerance_px > 0) solved = choose_model(input, options);
  return solved;
}

// The answer of a solved model; that of model weak, if it does not determine the focal length.
Calibration report_solved(ModelChoice& solved, Solution solution) {
  const CalibrateOptions& options = *solution.options;
  continue_until_converged(solved.fit.bundle, solved.fit.summary, options.max_iterations);
  solution.fit = &solved.fit;
  solution.supported = solved.supported;
  if (solved.status != Status::ok)
    solution.refusal = finding(refusal_code(solved.status), solved.reason);
  if (solved.weak) return calibrate_weak(*solution.input, options, solution.refusal);
  Calibration c = report(solution, gather_evidence(solution));
  if (!is_auto(options) || c.status != Status::focal_not_observable) return c;
  // Close to the bound of the focal length the noise of this fit differs from that of the ladder.
  return calibrate_weak(*solution.input, options,
                        *std::ranges::find(c.findings, Severity::refusal, &Finding::severity));
}

// Fits robustly, and reports. `board`: null, if there is not one flat board.
Calibration calibrate_input(CalibrationInput& input, const CalibrateOptions& options,
                            const FlatBoard* board) {
  std::optional<AlternativeLens> alternative;
  std::optional<ModelChoice> solved = fit_robustly(input, options, alternative);
  if (!solved) return no_answer(input, is_auto(options) ? "" : options.model);
  Solution solution{&input, nullptr, &options, board, {}, {}};
  if (alternative) solution.alternative = &*alternative;
  Calibration c = report_solved(*solved, solution);
  c.steps = solved->steps;
  c.bic = solved->fit.bic;
  return c;
}

}  // namespace

void check_options(const CalibrateOptions& options) {
  check_lens_options(options);
  if (!is_auto(options) && is_weak(Model::named(options.model)) && options.board_warp)
    throw Error("board_warp: model weak has no perspective, which a bend needs to be visible");
  if (!(options.tolerance_px >= 0))
    throw Error("tolerance_px: must be >= 0, got " + short_number(options.tolerance_px));
  if (options.tolerance_px > 0 && !is_auto(options))
    throw Error("tolerance_px: needs model auto, got " + options.model);
  for (const double distance : options.distances_m)
    if (!(distance > 0)) throw Error("distances_m: must be > 0, got " + short_number(distance));
}

Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options) {
  const auto begin = Clock::now();
  check_options(options);
  if (options.start && options.start->image_size != dataset.image_size)
    throw Error("start: must have the image size of the data set");
  const std::optional<FlatBoard> board = flat_board(dataset);
  if (options.board_warp && !board)
    throw Error("board_warp: needs exactly one board, and a flat one");
  CalibrationInput input = calibration_input(dataset, options);
  if (options.board_warp) input.bent_board = board;
  const bool is_weak_asked = !is_auto(options) && is_weak(Model::named(options.model));
  Calibration result = is_weak_asked ? calibrate_weak(input, options)
                                     : calibrate_input(input, options, board ? &*board : nullptr);
  result.model_error_px = input.model_error_px;
  result.outliers.insert(result.outliers.end(), input.rejected.begin(), input.rejected.end());
  result.seconds.total = seconds_since(begin);
  return result;
}

double camera_error_px(const Calibration& calibration) {
  double projection = 0;
  for (const ProjectionUncertainty& p : calibration.projection)
    if (std::isfinite(p.distance_m) || projection == 0) projection = p.region_px;
  const double noise =
      calibration.sigma_of_corners ? calibration.model_error_px : calibration.sigma_px;
  return std::hypot(noise, std::isfinite(projection) ? projection : 0);
}

}  // namespace tagcal
