#include "tagcal/estimate/calibrate.hpp"

#include <chrono>

#include "tagcal/error.hpp"
#include "tagcal/estimate/doubt.hpp"
#include "tagcal/estimate/ladder.hpp"
#include "tagcal/estimate/result.hpp"
#include "tagcal/estimate/settle.hpp"

namespace tagcal {
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
  c.status = any ? Status::no_consensus : Status::degenerate;
  c.warnings.push_back(any ? "in no view do the corners agree on a pose"
                           : "no view has four corners that are not on a line");
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

Calibration calibrate_auto(const CalibrationInput& input, const CalibrateOptions& options,
                           const FlatBoard* board) {
  std::optional<ModelChoice> choice = choose_model(input, options);
  if (!choice) return without_answer(input, "");
  Calibration c =
      choice->weak ? report_weak(*choice, options) : report(choice->fit, options, board);
  if (!choice->weak && c.status == Status::focal_not_observable) {
    // At the very bound, where the noise of all corners is not that of the ladder.
    choice->status = c.status;
    choice->reason = c.warnings.back();
    c = report_weak(*choice, options);
  }
  if (is_answer(c.status) && choice->status != Status::ok) {
    withdraw(c, choice->status, choice->reason);
  }
  c.steps = choice->steps;
  c.bic = choice->fit.bic;
  return c;
}

Calibration calibrate_model(const Model& model, const CalibrationInput& input,
                            const CalibrateOptions& options, const FlatBoard* board) {
  std::optional<CalibrationFit> fit = fit_model(model, input, options);
  if (!fit) return without_answer(input, std::string(model.name()));
  settle(fit->bundle, fit->summary, options.max_iterations);
  Calibration c = report(*fit, options, board);
  if (c.status == Status::not_converged && model.lens_type() == LensType::perspective) {
    const std::vector<Rung> rungs = climb(fit->bundle, model, options.max_iterations);
    fit = refit(rungs.back().bundle, *fit, input, options);
    if (!fit) return c;
    settle(fit->bundle, fit->summary, options.max_iterations);
    c = report(*fit, options, board);
  }
  const std::optional<Observability> doubt =
      is_answer(c.status) ? doubt_of_plain_lens(fit->bundle, c.covariance, c.sigma_px)
                          : std::nullopt;
  if (doubt) withdraw(c, doubt->status, doubt->reason);
  return c;
}

bool is_auto(const CalibrateOptions& options) {
  return options.model.empty() || options.model == "auto";
}

Calibration calibrate_input(const CalibrationInput& input, const CalibrateOptions& options,
                            const FlatBoard* board) {
  if (is_auto(options)) return calibrate_auto(input, options, board);
  return calibrate_model(Model::named(options.model), input, options, board);
}

Calibration calibrate_bent(const Dataset& dataset, const CalibrateOptions& options,
                           const FlatBoard& board) {
  CalibrationInput input = calibration_input(dataset, options.sigma_px > 0);
  const Eigen::Vector2d bent_m = unbend(input, board, options);
  Calibration c = calibrate_input(input, options, &board);
  if (c.board_warp) c.board_warp->bend_mm += 1e3 * bent_m;
  if (!is_auto(options) || !is_answer(c.status) || c.model == "weak") return c;
  // The choice was made on the board as the largest model bends it: the chosen one bends it its
  // way.
  CalibrateOptions chosen = options;
  chosen.model = c.model;
  Calibration own = calibrate_bent(dataset, chosen, board);
  if (!is_answer(own.status)) return c;
  own.steps = std::move(c.steps);
  own.bic = c.bic;  // on the board of `steps`
  return own;
}

}  // namespace

void check_options(const CalibrateOptions& options) {
  if (!is_auto(options) && Model::named(options.model).lens_type() == LensType::parallel)
    throw Error("model: weak is an answer for what holds no focal length; it cannot be asked for");
  for (const double distance : options.distances_m)
    if (!(distance > 0)) throw Error("distances_m: must be > 0, got " + std::to_string(distance));
}

Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options) {
  const auto begin = Clock::now();
  check_options(options);
  const std::optional<FlatBoard> board = flat_board(dataset);
  if (options.board_warp && !board) throw Error("board_warp: needs one board, and a flat one");
  Calibration result = options.board_warp
                           ? calibrate_bent(dataset, options, *board)
                           : calibrate_input(calibration_input(dataset, options.sigma_px > 0),
                                             options, board ? &*board : nullptr);
  result.seconds.total = seconds_since(begin);
  return result;
}

}  // namespace tagcal
