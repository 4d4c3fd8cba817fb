#include "tagcal/estimate/calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/convergence.hpp"
#include "tagcal/estimate/calibration/alternative_lens_test.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
#include "tagcal/estimate/calibration/model_choice.hpp"
#include "tagcal/estimate/calibration/model_error.hpp"
#include "tagcal/estimate/calibration/model_ladder.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/view_rejection.hpp"
#include "tagcal/estimate/checks/lack_of_fit.hpp"
#include "tagcal/estimate/checks/report.hpp"
#include "tagcal/estimate/checks/target_error.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The result if there is no fit.
Calibration no_answer(const CalibrationInput& input, const std::string& model) {
  Calibration c;
  c.model = model;
  c.findings = input.findings;
  const bool any = !input.views.empty();
  c.status = any || !input.rejected.empty() ? Status::no_consensus : Status::degenerate;
  if (any)
    add(c.findings, code::no_consensus,
        "the corners of no view are consistent with one pose: check that the target file describes "
        "the board, and the ids of the tags");
  else if (input.rejected.empty())
    add(c.findings, code::degenerate,
        "no view has four corners that are not on one line: no pose can be determined");
  return c;
}

// Replaces an answer by a refusal, and removes the claims that depend on it.
void revoke_answer(Calibration& c, Status status) {
  c.status = status;
  c.projection.clear();
  c.halves.reset();
  c.board_warp.reset();
}

// Tests for a target that is not as its file says: a corner's residuals then have the same
// direction on the board in all views. No test if a larger lens explains more of the residuals.
void check_target(Calibration& c, const CalibrationInput& input, const Bundle& solved,
                  const CalibrateOptions& options, const FlatBoard* board) {
  // A refused focal length may be the consequence of a wrong target.
  if (!is_answer(c.status) && c.status != Status::focal_not_observable) return;
  const auto error = target_error(input, c, board);
  if (!error) return;
  const auto larger = larger_lens(solved, c.sigma_px);
  if (larger && larger->share > std::max(error->share, policy::kLargerLensShare)) return;
  // A user who keeps all corners trusts the target.
  if (error->gross && options.reject_outliers) revoke_answer(c, Status::no_consensus);
  // First, because the other findings may follow from it.
  c.findings.insert(c.findings.begin(), error->findings.begin(), error->findings.end());
}

bool is_weak(const Model& model) { return model.lens_type() == LensType::parallel; }

Calibration calibrate_weak(const CalibrationInput& input, const CalibrateOptions& options) {
  const std::optional<WeakFit> weak = fit_weak(input, options);
  if (!weak) return no_answer(input, "weak");
  return report_weak(*weak, options);
}

constexpr int kRejectionRounds = 4;  // limits of work
constexpr int kModelErrorRounds = 3;

// Chooses the model and estimates the error of lens and target in turn.
std::optional<ModelChoice> choose_with_model_error(CalibrationInput& input,
                                                   const CalibrateOptions& options) {
  std::optional<ModelChoice> choice = choose_model(input, options);
  // The residuals of a refused model are no estimate of that error.
  for (int i = 0; choice && choice->status == Status::ok && i < kModelErrorRounds; ++i) {
    if (!update_model_error(input, choice->fit)) break;
    choice = choose_model(input, options);
  }
  return choice;
}

std::optional<CalibrationFit> fit_with_model_error(const Model& model, CalibrationInput& input,
                                                   const CalibrateOptions& options) {
  std::optional<CalibrationFit> fit = fit_model(model, input, options);
  for (int i = 0; fit && i < kModelErrorRounds && update_model_error(input, *fit); ++i)
    fit = fit_model(model, input, options);
  return fit;
}

// Rejects outlying views and chooses the model in turn.
std::optional<ModelChoice> choose_model_robustly(CalibrationInput& input,
                                                 const CalibrateOptions& options) {
  // Views are judged by the best model: the misfit of a smaller one that a tolerance allows is no
  // reason to reject them.
  CalibrateOptions best = options;
  best.tolerance_px = 0;
  std::optional<ModelChoice> choice = choose_with_model_error(input, best);
  for (int round = 0; choice && options.reject_outliers && round < kRejectionRounds; ++round) {
    if (!reject_outlying_views(input, choice->fit, best)) break;
    choice = choose_with_model_error(input, best);
  }
  if (choice && options.tolerance_px > 0) choice = choose_model(input, options);
  return choice;
}

Calibration calibrate_auto(CalibrationInput& input, const CalibrateOptions& options,
                           const FlatBoard* board) {
  std::optional<ModelChoice> choice = choose_model_robustly(input, options);
  if (!choice) return no_answer(input, "");
  Calibration c = choice->weak ? calibrate_weak(input, options)
                               : report(choice->fit, options, board, choice->supported);
  if (!choice->weak) check_target(c, input, choice->fit.bundle, options, board);
  if (!choice->weak && c.status == Status::focal_not_observable) {
    // Close to the bound of the focal length: the noise of this fit differs from that of the
    // ladder.
    choice->status = c.status;
    const auto refusal = std::ranges::find(c.findings, refusal_code(c.status).name, &Finding::code);
    choice->reason = refusal->sentence;
    c = calibrate_weak(input, options);
  }
  if (is_answer(c.status) && choice->status != Status::ok) {
    revoke_answer(c, choice->status);
    c.findings = choice->fit.findings;  // without those about the revoked answer
    add(c.findings, refusal_code(choice->status), choice->reason);
  }
  c.steps = choice->steps;
  c.bic = choice->fit.bic;
  return c;
}

// Looks for a better minimum than `fit`: fits the nested models from its poses and from those of a
// fisheye, each from the next smaller one. No value if none explains the corners better.
std::optional<CalibrationFit> fit_from_other_starts(const CalibrationFit& fit, const Model& model,
                                                    const CalibrationInput& input,
                                                    const CalibrateOptions& options) {
  std::vector<CalibrationFit> starts = {fit};
  if (auto fisheye = fit_model(input.models->named("fisheye4"), input, options)) {
    fisheye->bundle = with_model(fisheye->bundle, input.models->named("f"));
    if (solve(fisheye->bundle, options.max_iterations).converged)
      starts.push_back(std::move(*fisheye));
  }
  const double sigma = std::sqrt(fit.summary.cost / std::max(1, degrees_of_freedom(fit.bundle)));
  std::optional<CalibrationFit> best;
  for (const CalibrationFit& start : starts) {
    const std::vector<Candidate> candidates =
        fit_nested(start.bundle, model, options.max_iterations);
    auto other = refit(candidates.back().bundle, start, input, options);
    if (!other || !other->summary.converged) continue;
    if (!best || other->truncated_chi_square(sigma) < best->truncated_chi_square(sigma))
      best = std::move(other);
  }
  const bool is_better = best && (!fit.summary.converged || best->truncated_chi_square(sigma) <
                                                                fit.truncated_chi_square(sigma));
  return is_better ? best : std::nullopt;
}

Calibration converge_and_report(CalibrationFit& fit, const CalibrateOptions& options,
                                const FlatBoard* board) {
  continue_until_converged(fit.bundle, fit.summary, options.max_iterations);
  return report(fit, options, board);
}

// Refuses an answer that a nested, simpler model contradicts.
void check_simpler_model(Calibration& c, const CalibrationFit& fit) {
  if (!is_answer(c.status)) return;
  const auto refusal = simpler_model_test(fit.bundle, c.covariance, c.sigma_px);
  if (!refusal) return;
  revoke_answer(c, refusal->status);
  add(c.findings, refusal_code(refusal->status), refusal->reason);
}

// Warns if the other kind of lens explains the corners better.
void check_alternative_lens(Calibration& c, const std::optional<AlternativeLens>& alternative,
                            const CalibrateOptions& options) {
  if (!is_answer(c.status) || !alternative) return;
  if (auto sentence = alternative_lens_test(*alternative, options, sigma_with_floor(c, options)))
    add(c.findings, code::other_lens, *sentence);
}

Calibration calibrate_model(const Model& model, CalibrationInput& input,
                            const CalibrateOptions& options, const FlatBoard* board) {
  if (is_weak(model)) return calibrate_weak(input, options);
  std::optional<CalibrationFit> fit = fit_with_model_error(model, input, options);
  const auto alternative = fit ? alternative_lens(*fit, input) : std::nullopt;
  for (int round = 0; fit && options.reject_outliers && round < kRejectionRounds; ++round) {
    if (!reject_outlying_views(input, *fit, options)) break;
    fit = fit_with_model_error(model, input, options);
  }
  if (!fit) return no_answer(input, std::string(model.name()));
  Calibration c = converge_and_report(*fit, options, board);
  const bool is_secondary_minimum_likely =
      c.status == Status::not_converged || c.variance_inflation > 1;
  if (is_secondary_minimum_likely && model.lens_type() == LensType::perspective) {
    if (auto other = fit_from_other_starts(*fit, model, input, options)) {
      fit = std::move(other);
      c = converge_and_report(*fit, options, board);
    }
  }
  check_simpler_model(c, *fit);
  check_alternative_lens(c, alternative, options);
  check_target(c, input, fit->bundle, options, board);
  return c;
}

Calibration calibrate_input(CalibrationInput& input, const CalibrateOptions& options,
                            const FlatBoard* board) {
  Calibration c = is_auto(options)
                      ? calibrate_auto(input, options, board)
                      : calibrate_model(input.models->named(options.model), input, options, board);
  c.model_error_px = input.model_error_px;
  c.outliers.insert(c.outliers.end(), input.rejected.begin(), input.rejected.end());
  return c;
}

// Estimates the bend of the board first, then calibrates with the bent points.
Calibration calibrate_with_board_warp(const CalibrationInput& flat, const CalibrateOptions& options,
                                      const FlatBoard& board) {
  CalibrationInput input = flat;
  const Eigen::Vector2d bent_m = remove_board_warp(input, board, options);
  Calibration c = calibrate_input(input, options, &board);
  if (c.board_warp) {
    c.board_warp->bend_mm += 1e3 * bent_m;
    warn_of_impossible_bend(c, *c.board_warp, board);
  }
  if (!is_auto(options) || !is_answer(c.status) || c.model == "weak") return c;
  // The model was chosen with the bend under the largest model: the chosen one estimates its own.
  CalibrateOptions chosen = options;
  chosen.model = c.model;
  Calibration own = calibrate_with_board_warp(flat, chosen, board);
  if (!is_answer(own.status)) return c;
  own.steps = std::move(c.steps);
  own.bic = c.bic;  // with the bend of `steps`
  return own;
}

}  // namespace

void check_options(const CalibrateOptions& options) {
  check_start(options);
  check_fixed(options);
  if (!is_auto(options) && is_weak(Model::named(options.model)) && options.board_warp)
    throw Error("board_warp: model weak has no perspective, which a bend needs to be visible");
  if (!(options.tolerance_px >= 0))
    throw Error("tolerance_px: must be >= 0, got " + std::to_string(options.tolerance_px));
  if (options.tolerance_px > 0 && !is_auto(options))
    throw Error("tolerance_px: needs model auto, got " + options.model);
  for (const double distance : options.distances_m)
    if (!(distance > 0)) throw Error("distances_m: must be > 0, got " + std::to_string(distance));
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
  Calibration result = options.board_warp
                           ? calibrate_with_board_warp(input, options, *board)
                           : calibrate_input(input, options, board ? &*board : nullptr);
  result.seconds.total = seconds_since(begin);
  return result;
}

}  // namespace tagcal
