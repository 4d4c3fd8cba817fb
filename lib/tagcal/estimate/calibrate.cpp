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

namespace tagcal {
using namespace internal;
namespace {

using Clock = std::chrono::steady_clock;

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
void withdraw(Calibration& c, Status status) {
  c.status = status;
  c.projection.clear();
  c.halves.reset();
  c.board_warp.reset();
}

constexpr double kShareOfLargerLens = 0.1;

// A target that is wrong in every view fits itself, but for the residuals of its corners, which
// have one direction on it. (Not where a larger lens explains more of them.)
void check_target(Calibration& c, const CalibrationInput& input, const Bundle& solved,
                  const CalibrateOptions& options, const FlatBoard* board) {
  // A wrong target may be why the residuals refuse a focal length.
  if (!is_answer(c.status) && c.status != Status::focal_not_observable) return;
  const auto error = target_error(input, c, board);
  if (!error) return;
  const auto larger = larger_lens(solved, c.sigma_px);
  if (larger && larger->share > std::max(error->share, kShareOfLargerLens)) return;
  // Who keeps all corners knows better.
  if (error->gross && options.reject_outliers) withdraw(c, Status::no_consensus);
  // What else is warned of follows from it.
  c.warnings.insert(c.warnings.begin(), error->sentences.begin(), error->sentences.end());
}

bool is_weak(const Model& model) { return model.lens_type() == LensType::parallel; }

Calibration calibrate_weak(const CalibrationInput& input, const CalibrateOptions& options) {
  const std::optional<WeakFit> weak = fit_weak(input, options);
  if (!weak) return without_answer(input, "weak");
  return report_weak(*weak, options);
}

constexpr int kMostRounds = 4;        // of leaving out what stands out
constexpr int kModelErrorRounds = 3;  // until it stays the same

// The smallest model that explains the data, with what the lens and the target are wrong by.
std::optional<ModelChoice> choose_with_model_error(CalibrationInput& input,
                                                   const CalibrateOptions& options) {
  std::optional<ModelChoice> choice = choose_model(input, options);
  // A model that does not explain the corners says nothing of the error of the lens.
  for (int i = 0; choice && choice->status == Status::ok && i < kModelErrorRounds; ++i) {
    if (!count_model_error(input, choice->fit)) break;
    choice = choose_model(input, options);
  }
  return choice;
}

std::optional<CalibrationFit> fit_with_model_error(const Model& model, CalibrationInput& input,
                                                   const CalibrateOptions& options) {
  std::optional<CalibrationFit> fit = fit_model(model, input, options);
  for (int i = 0; fit && i < kModelErrorRounds && count_model_error(input, *fit); ++i)
    fit = fit_model(model, input, options);
  return fit;
}

// A large lens bends to a wrong view, so that this no longer stands out: a smaller one is asked,
// too, wherever a large one was chosen or more than a few corners were rejected.
bool leave_out_of_choice(CalibrationInput& input, const CalibrationFit& chosen,
                         const CalibrateOptions& options) {
  if (leave_out_what_stands_out(input, chosen, options)) return true;
  const Model& usual = input.models->named("opencv5");
  const bool large = chosen.bundle.model->num_free() > usual.num_free() ||
                     chosen.bundle.model->lens_type() == LensType::fisheye;
  if (!large && 50 * chosen.num_inliers() > 49 * chosen.num_corners) return false;
  const std::optional<CalibrationFit> fit = fit_model(usual, input, options);
  CalibrationInput without = input;
  if (!fit || !leave_out_what_stands_out(without, *fit, options)) return false;
  if (large && explains_left_out(chosen, without, options)) return false;
  input = std::move(without);
  return true;
}

Calibration calibrate_auto(CalibrationInput& input, const CalibrateOptions& options,
                           const FlatBoard* board) {
  // Views are judged by the best model: what a tolerance leaves out is no reason to reject them.
  CalibrateOptions best = options;
  best.tolerance_px = 0;
  std::optional<ModelChoice> choice = choose_with_model_error(input, best);
  for (int round = 0; choice && options.reject_outliers && round < kMostRounds; ++round) {
    if (!leave_out_of_choice(input, choice->fit, best)) break;
    choice = choose_with_model_error(input, best);
  }
  if (choice && options.tolerance_px > 0) choice = choose_model(input, options);
  if (!choice) return without_answer(input, "");
  Calibration c = choice->weak ? calibrate_weak(input, options)
                               : report(choice->fit, options, board, choice->supported);
  if (!choice->weak) check_target(c, input, choice->fit.bundle, options, board);
  if (!choice->weak && c.status == Status::focal_not_observable) {
    // At the very bound, where the noise of all corners is not that of the ladder.
    choice->status = c.status;
    choice->reason = c.warnings.back();
    c = calibrate_weak(input, options);
  }
  if (is_answer(c.status) && choice->status != Status::ok) {
    withdraw(c, choice->status);
    c.warnings = choice->fit.warnings;  // the others are about the answer
    c.warnings.push_back(choice->reason);
  }
  c.steps = choice->steps;
  c.bic = choice->fit.bic;
  return c;
}

// What stands at the fold of a lens, or does not explain the corners, may be a second minimum: the
// models below, from the same poses and from those of a fisheye, lead to others. No value where
// none explains the corners better.
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
    const std::vector<Rung> rungs = climb(start.bundle, model, options.max_iterations);
    auto other = refit(rungs.back().bundle, start, input, options);
    if (!other || !other->summary.converged) continue;
    if (!best || other->truncated_misfit(sigma) < best->truncated_misfit(sigma))
      best = std::move(other);
  }
  const bool is_better = best && (!fit.summary.converged ||
                                  best->truncated_misfit(sigma) < fit.truncated_misfit(sigma));
  return is_better ? best : std::nullopt;
}

Calibration calibrate_model(const Model& model, CalibrationInput& input,
                            const CalibrateOptions& options, const FlatBoard* board) {
  if (is_weak(model)) return calibrate_weak(input, options);
  std::optional<CalibrationFit> fit = fit_with_model_error(model, input, options);
  const auto question = fit ? question_of_lens(*fit, input) : std::nullopt;
  for (int round = 0; fit && options.reject_outliers && round < kMostRounds; ++round) {
    if (!leave_out_what_stands_out(input, *fit, options)) break;
    fit = fit_with_model_error(model, input, options);
  }
  if (!fit) return without_answer(input, std::string(model.name()));
  settle(fit->bundle, fit->summary, options.max_iterations);
  Calibration c = report(*fit, options, board);
  const bool is_doubtful = c.status == Status::not_converged || c.variance_inflation > 1;
  if (is_doubtful && model.lens_type() == LensType::perspective) {
    if (auto other = fit_from_other_starts(*fit, model, input, options)) {
      fit = std::move(other);
      settle(fit->bundle, fit->summary, options.max_iterations);
      c = report(*fit, options, board);
    }
  }
  const std::optional<Observability> doubt =
      is_answer(c.status) ? doubt_of_plain_lens(fit->bundle, c.covariance, c.sigma_px)
                          : std::nullopt;
  if (doubt) {
    withdraw(c, doubt->status);
    c.warnings.push_back(doubt->reason);
  }
  if (is_answer(c.status) && question)
    if (auto sentence = better_other_lens(*question, options, sigma_that_counts(c, options)))
      c.warnings.push_back(*sentence);
  check_target(c, input, fit->bundle, options, board);
  return c;
}

bool is_auto(const CalibrateOptions& options) {
  return options.model.empty() || options.model == "auto";
}

Calibration calibrate_input(CalibrationInput& input, const CalibrateOptions& options,
                            const FlatBoard* board) {
  Calibration c = is_auto(options)
                      ? calibrate_auto(input, options, board)
                      : calibrate_model(input.models->named(options.model), input, options, board);
  c.model_error_px = input.model_error_px;
  c.outliers.insert(c.outliers.end(), input.dropped.begin(), input.dropped.end());
  return c;
}

Calibration calibrate_bent(const CalibrationInput& flat, const CalibrateOptions& options,
                           const FlatBoard& board) {
  CalibrationInput input = flat;
  const Eigen::Vector2d bent_m = unbend(input, board, options);
  Calibration c = calibrate_input(input, options, &board);
  if (c.board_warp) {
    c.board_warp->bend_mm += 1e3 * bent_m;
    warn_of_impossible_bend(c, *c.board_warp, board);
  }
  if (!is_auto(options) || !is_answer(c.status) || c.model == "weak") return c;
  // The choice was made on the board as the largest model bends it: the chosen one bends it its
  // way.
  CalibrateOptions chosen = options;
  chosen.model = c.model;
  Calibration own = calibrate_bent(flat, chosen, board);
  if (!is_answer(own.status)) return c;
  own.steps = std::move(c.steps);
  own.bic = c.bic;  // on the board of `steps`
  return own;
}

}  // namespace

void check_options(const CalibrateOptions& options) {
  check_start(options);
  check_fixed(options);
  if (!is_auto(options) && is_weak(Model::named(options.model)) && options.board_warp)
    throw Error("board_warp: model weak holds no perspective that would show a bent board");
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
  if (options.board_warp && !board) throw Error("board_warp: needs one board, and a flat one");
  CalibrationInput input = calibration_input(dataset, options);
  Calibration result = options.board_warp
                           ? calibrate_bent(input, options, *board)
                           : calibrate_input(input, options, board ? &*board : nullptr);
  result.seconds.total = seconds_since(begin);
  return result;
}

}  // namespace tagcal
