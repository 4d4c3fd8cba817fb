#include "tagcal/estimate/calibrate.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/kinds.hpp"
#include "tagcal/estimate/calibration/model_choice.hpp"
#include "tagcal/estimate/calibration/model_error.hpp"
#include "tagcal/estimate/calibration/readout_rounds.hpp"
#include "tagcal/estimate/calibration/view_rejection.hpp"
#include "tagcal/estimate/calibration/weak_calibration.hpp"
#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/checks/report.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/view_checks.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
namespace {

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

bool is_weak(const Model& model) { return !model.kind().is_central; }

// `refusal`: of a model with perspective, or none.
Calibration calibrate_weak(const CalibrationInput& input, const CalibrateOptions& options,
                           std::optional<Finding> refusal = {}) {
  const std::optional<CalibrationFit> fit = fit_weak(input, options);
  if (!fit) return no_answer(input, "weak");
  return report({&input, &*fit, &options, nullptr, std::move(refusal)},
                evidence_of_noise(*fit, options));
}

// The views show row terms under the best lens of all, or are too few to tell.
bool best_lens_shows_rows(const CalibrationInput& input, CalibrateOptions options) {
  if (std::ssize(input.views) < policy::kFewestTellingViews) return true;
  options.model.clear();
  options.fixed.clear();
  CalibrationInput open = spread_views(input, policy::kChoiceViews);
  open.models = models_of(options);
  const Kinds kinds = fit_kinds(open, options);
  const Posterior* best = best_of(kinds);
  return best && best->fit.bundle.row_sigma > 0;
}

// Fits the model that the user named, or chooses one. Row terms belong to the pictures: what a lens
// that is too small, or held at wrong values, leaves in the residuals looks like displaced rows.
// The best lens is asked once: `input` keeps what it shows.
std::optional<ModelChoice> fit_or_choose(CalibrationInput& input, const CalibrateOptions& options) {
  auto choice = is_auto(options) ? choose_model(input, options) : fit_named(input, options);
  const bool is_restricted = !is_auto(options) || !options.fixed.empty();
  if (!choice || !is_restricted || input.has_rows || !(choice->posterior.fit.bundle.row_sigma > 0))
    return choice;
  input.has_rows = best_lens_shows_rows(input, options);
  if (*input.has_rows) return choice;
  return fit_or_choose(input, options);
}

// Fits, estimates the error of lens and target, and rejects outlying views, until nothing changes.
// Corners and views are judged by the posterior, not by a smaller answer.
std::optional<ModelChoice> fit_robustly(CalibrationInput& input, const CalibrateOptions& options) {
  constexpr int kRounds = 10;  // a limit of work
  std::optional<ModelChoice> solved = fit_or_choose(input, options);
  for (int round = 0; solved && round < kRounds; ++round) {
    const CalibrationFit& judge = solved->posterior.fit;
    if (!update_model_error(input, judge) &&
        !(options.reject_outliers && reject_outlying_views(input, judge, options)))
      break;
    solved = fit_or_choose(input, options);
  }
  return solved;
}

// The steps with that of model weak, which has no perspective.
std::vector<ModelStep> with_weak(std::vector<ModelStep> steps, bool is_taken) {
  if (is_taken)
    for (ModelStep& step : steps) step.taken = false;
  ModelStep weak;
  weak.model = "weak";
  weak.taken = is_taken;
  weak.sentence = is_taken ? "taken: the data determine no focal length"
                           : "not needed: the data determine a focal length";
  steps.insert(steps.begin(), weak);
  return steps;
}

// Fits robustly, and reports; model weak, if the focal length is not determined.
Calibration calibrate_input(CalibrationInput& input, const CalibrateOptions& options) {
  std::optional<ModelChoice> solved = fit_robustly(input, options);
  if (!solved) return no_answer(input, is_auto(options) ? "" : options.model);
  const Solution solution{&input, &solved->fit, &options, &*solved, {}};
  Calibration c = report(solution, gather_evidence(solution));
  // A motion during the readout that is in all corners may be why the focal length is not known.
  const bool is_readout_seen = c.readout && c.readout->is_seen;
  const bool is_weak_taken =
      is_auto(options) && c.status == Status::focal_not_observable && !is_readout_seen;
  if (is_weak_taken)
    c = calibrate_weak(input, options,
                       *std::ranges::find(c.findings, Severity::refusal, &Finding::severity));
  if (is_auto(options)) c.steps = with_weak(std::move(solved->steps), is_weak_taken);
  return c;
}

// The data set with left-handed coordinates of its measured points; no value if it has other
// boards.
std::optional<Dataset> with_mirrored_points(const Dataset& dataset) {
  Dataset mirrored = dataset;
  for (PlacedBoard& placed : mirrored.boards) {
    auto* const points = std::get_if<Points>(&placed.board.pattern);
    if (!points) return std::nullopt;
    for (TargetPoint& point : points->points) point.position.x() *= -1;
  }
  return mirrored;
}

Calibration calibrate_dataset(const Dataset& dataset, const CalibrateOptions& options) {
  const std::optional<FlatBoard> board = flat_board(dataset);
  if (options.board_warp && !board)
    throw Error("board_warp: needs exactly one board, and a flat one");
  CalibrationInput input = calibration_input(dataset, options);
  input.board = board;
  const bool is_weak_asked = !is_auto(options) && is_weak(Model::named(options.model));
  Calibration result =
      is_weak_asked ? calibrate_weak(input, options) : calibrate_input(input, options);
  result.model_error_px = input.model_error_px;
  result.outliers.insert(result.outliers.end(), input.rejected.begin(), input.rejected.end());
  return result;
}

// Says so if measured points fit in their mirror image only.
void test_mirror_image(const Dataset& dataset, const CalibrateOptions& options,
                       Calibration& result) {
  if (result.status != Status::no_consensus) return;
  const std::optional<Dataset> mirrored = with_mirrored_points(dataset);
  if (!mirrored || !is_answer(calibrate_dataset(*mirrored, options).status)) return;
  say_mirror_image_fits(result.findings);
}

// Says which held values the data contradict: a calibration without --fix gives others.
void test_held_values(const Dataset& dataset, CalibrateOptions options, Calibration& result) {
  if (options.fixed.empty() || !is_answer(result.status) || !result.claim) return;
  options.fixed.clear();
  const Calibration open = calibrate(dataset, options);
  if (!is_answer(open.status) || !open.claim) return;
  const std::span<const std::string_view> names = parameter_names(open.camera->lens);
  std::vector<std::string> contradicted;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto held = result.fixed.find(std::string(names[i]));
    const double value = parameters(open.camera->lens)[i], sigma = open.sigmas[i];
    if (held == result.fixed.end() || sigma == 0 ||  // the model holds it itself
        !(std::abs(held->second - value) > policy::kSignificant * sigma))
      continue;
    contradicted.push_back(held->first + " " + short_number(held->second) + " (without it " +
                           with_sigma(value, sigma) + ")");
  }
  if (contradicted.empty()) return;
  const Finding found =
      finding(code::held_contradicted,
              "the corners contradict what --fix holds: " + listed(contradicted) +
                  "; other parameters take up the error, which no standard deviation includes: "
                  "check the values, or leave them out");
  result.findings.insert(result.findings.begin(), found);
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
  for (const double time : options.times_s)
    if (!std::isfinite(time)) throw Error("times_s: must be finite, got " + short_number(time));
  for (const double distance : options.distances_m)
    if (!(distance > 0)) throw Error("distances_m: must be > 0, got " + short_number(distance));
}

Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options) {
  const Stopwatch stopwatch;
  check_options(options);
  if (options.start && options.start->image_size != dataset.image_size)
    throw Error("start: must have the image size of the data set");
  if (!options.sources.empty() && options.sources.size() != dataset.views.size())
    throw Error("sources: must name the source of each of " + std::to_string(dataset.views.size()) +
                " views, got " + std::to_string(options.sources.size()));
  if (!options.times_s.empty() && options.times_s.size() != dataset.views.size())
    throw Error("times_s: must have the time of each of " + std::to_string(dataset.views.size()) +
                " views, got " + std::to_string(options.times_s.size()));
  Calibration result = calibrate_dataset(dataset, options);
  if (!options.times_s.empty())
    result = calibrate_with_readout(
        dataset, options.times_s, std::move(result),
        [&](const Dataset& still) { return calibrate_dataset(still, options); });
  if (!is_answer(result.status)) result.readout.reset();
  test_mirror_image(dataset, options, result);
  test_held_values(dataset, options, result);
  result.seconds.total = stopwatch.seconds();
  return result;
}

double camera_error_px(const Calibration& calibration) {
  const double projection =
      calibration.projection.size() > 1 ? calibration.projection[1].region_px : 0;
  const double noise =
      calibration.sigma_of_corners ? calibration.model_error_px : calibration.sigma_px;
  return std::hypot(noise, std::isfinite(projection) ? projection : 0);
}

}  // namespace tagcal
