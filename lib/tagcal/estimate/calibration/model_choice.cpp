#include "tagcal/estimate/calibration/model_choice.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tagcal/estimate/bundle/lack_of_fit.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/model_ladder.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/weak_calibration.hpp"
#include "tagcal/estimate/calibration_diff.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector2d;

// With so many significant digits; no exponent for large numbers.
std::string number(double value, int digits) {
  return std::abs(value) < 1000 ? with_digits(value, digits) : with_decimals(value, 0);
}

// BIC, with the handicap of a fisheye; it has none against the rational lens, which is as flexible.
double score(const Candidate& candidate, const ModelLadder& ladder) {
  if (!candidate.is_fisheye()) return candidate.bic;
  const Candidate* best = nullptr;
  for (const Candidate& other : ladder.candidates)
    if (!other.is_fisheye() && other.is_usable() && (!best || other.bic < best->bic)) best = &other;
  const bool is_rational = best && best->model().name() == "opencv8";
  return candidate.bic +
         (is_rational ? 0 : policy::kFisheyeHandicap * std::log(ladder.num_residuals));
}

// The fisheye can be chosen only if its score beats every perspective model, observable or not:
// otherwise it would answer for data that do not determine a perspective.
bool is_eligible(const Candidate& candidate, const ModelLadder& ladder) {
  if (!candidate.is_usable() || !candidate.is_fisheye()) return candidate.is_usable();
  return std::all_of(
      ladder.candidates.begin(), ladder.candidates.end(), [&](const Candidate& other) {
        return other.is_estimated || score(candidate, ladder) <= score(other, ladder);
      });
}

const Candidate* lowest_score(const ModelLadder& ladder) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : ladder.candidates)
    if (is_eligible(candidate, ladder) &&
        (!best || score(candidate, ladder) < score(*best, ladder)))
      best = &candidate;
  return best;
}

// Pixels and distance at which projections are compared.
struct Comparison {
  std::vector<Vector2d> samples;
  double distance_m = 1;

  explicit Comparison(const Bundle& bundle)
      : samples(seen_region(bundle).samples()), distance_m(median_distance_m(bundle)) {}
};

ProjectionUncertainty uncertainty(const Candidate& candidate, const Comparison& at) {
  return projection_uncertainty(
      {&candidate.model(), candidate.bundle.lens(), candidate.observability.covariance->parameters},
      ImageGrid{candidate.bundle.image_size}, at.samples, at.distance_m);
}

// The two models differ by at most the larger one's standard deviation (per coordinate) at every
// node of the image. A node that only one of them sees is a difference.
bool agrees_everywhere(const ProjectionUncertainty& large, const LensDifference& d) {
  for (Eigen::Index row = 0; row < large.sigma_px.rows(); ++row) {
    for (Eigen::Index column = 0; column < large.sigma_px.cols(); ++column) {
      const double sigma = large.sigma_px(row, column);
      if (std::isnan(sigma)) continue;
      const double difference = std::hypot(d.u_px(row, column), d.v_px(row, column));
      if (!(difference <= std::sqrt(2.0) * sigma)) return false;
    }
  }
  return true;
}

Camera camera_of(const Candidate& candidate) {
  return {candidate.bundle.lens(), candidate.bundle.image_size};
}

// The smallest perspective that can replace the winner; sets the differences of all to the winner.
const Candidate* smallest_equivalent(const ModelLadder& ladder, const Candidate& winner,
                                     double tolerance_px,
                                     std::vector<std::optional<double>>& differences) {
  if (winner.is_fisheye()) return &winner;
  const Comparison at(winner.bundle);
  const ProjectionUncertainty sigma = uncertainty(winner, at);
  const Candidate* smallest = &winner;
  for (std::size_t i = ladder.candidates.size(); i-- > 0;) {
    const Candidate& candidate = ladder.candidates[i];
    if (&candidate == &winner || !candidate.is_usable() || candidate.is_fisheye()) continue;
    const auto d =
        lens_difference(camera_of(winner), camera_of(candidate), at.samples, at.distance_m);
    if (!d) continue;
    differences[i] = d->rms_px;
    if (candidate.model().num_free() < winner.model().num_free() &&
        (d->rms_px <= tolerance_px || agrees_everywhere(sigma, *d)))
      smallest = &candidate;
  }
  return smallest;
}

// A perspective that is better than the winner by strong evidence, but is not determined.
const Candidate* better_but_undetermined(const ModelLadder& ladder, const Candidate& winner) {
  for (const Candidate& candidate : ladder.candidates) {
    if (candidate.is_determined() || !candidate.summary.converged || candidate.is_fisheye() ||
        winner.is_fisheye())
      continue;
    if (candidate.bic < winner.bic - policy::kStrongEvidence) return &candidate;
  }
  return nullptr;
}

ModelStep weak_step(const ModelLadder& ladder, bool taken) {
  ModelStep step;
  step.model = "weak";
  step.taken = taken;
  step.sentence = taken ? "taken: the data determine no focal length"
                        : "not needed: the data determine a focal length";
  const Bundle& bundle = ladder.candidates.front().bundle;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto view = fit_weak_view(bundle.views[v], image_centre(bundle.image_size),
                                    bundle.camera_from_target[v]);
    if (view) step.cost += view->cost;
  }
  step.bic = step.cost / ladder.noise_square;
  return step;
}

// "RMS residual 0.312 px, that of f 0.874 px", with the digits that tell the two apart.
std::string residuals_text(const Candidate& candidate, const Candidate& other,
                           const ModelLadder& ladder) {
  const auto rms = [&](const Candidate& c) {
    return std::sqrt(c.chi_square * ladder.noise_square / std::max(1, ladder.num_residuals));
  };
  const char* const unit = ladder.whitened ? " sd" : " px";
  std::string own, others;
  for (int digits = 3; digits <= 9 && own == others; ++digits) {
    own = number(rms(candidate), digits);
    others = number(rms(other), digits);
  }
  return "RMS residual " + own + unit + ", that of " + std::string(other.model().name()) + " " +
         others + unit;
}

// Why a model was taken or not, against `last`: the last one taken, or the chosen one (null: none).
std::string step_sentence(const Candidate& candidate, const Candidate* last,
                          const ModelLadder& ladder, bool taken) {
  if (!candidate.is_determined())
    return "not taken, the data do not determine it: " + candidate.observability.reason;
  if (!candidate.summary.converged) return "not taken: the solver did not converge";
  if (candidate.has_pole) return "not taken: its distortion has a pole inside the image";
  if (!last || last == &candidate)
    return taken ? "taken: the data determine its parameters" : "not taken";
  const int more = candidate.model().num_free() - last->model().num_free();
  std::string text = residuals_text(candidate, *last, ladder);
  if (more > 0)
    text += ", " + std::to_string(more) + (more == 1 ? " parameter more" : " parameters more");
  if (candidate.is_estimated) text += ", estimated from a part of the views";
  return text + (taken ? ": taken" : ": not needed");
}

std::vector<ModelStep> model_steps(const ModelLadder& ladder, const Candidate* chosen,
                                   const Candidate* winner,
                                   const std::vector<std::optional<double>>& differences) {
  std::vector<ModelStep> steps = {weak_step(ladder, chosen == nullptr)};
  const Candidate* last = nullptr;
  bool done = chosen == nullptr;
  const double chosen_difference =
      chosen ? differences[static_cast<std::size_t>(chosen - ladder.candidates.data())].value_or(0)
             : 0;
  for (std::size_t i = 0; i < ladder.candidates.size(); ++i) {
    const Candidate& candidate = ladder.candidates[i];
    ModelStep step;
    step.model = candidate.model().name();
    step.num_parameters = candidate.model().num_free();
    step.cost = candidate.chi_square * ladder.noise_square;
    step.bic = candidate.bic;
    step.difference_px = differences[i];
    const bool on_the_way = chosen && !done && candidate.is_usable() && !candidate.is_fisheye() &&
                            !chosen->is_fisheye() && (!last || candidate.bic < last->bic);
    step.taken = &candidate == chosen || on_the_way;
    step.sentence =
        step_sentence(candidate, last || step.taken ? last : chosen, ladder, step.taken);
    if (&candidate == winner && winner != chosen)
      step.sentence += ", the projections differ by " + number(chosen_difference, 3) + " px";
    if (step.taken) last = &candidate;
    done |= &candidate == chosen;
    steps.push_back(std::move(step));
  }
  return steps;
}

void add_weight(ModelStep& step, double weight) {
  step.weight = weight;
  if (weight > policy::kNamedModelWeight)
    step.sentence += "; has " + percent(weight) + " of the weight in the standard deviations";
}

double noise_of_residuals(const CalibrationFit& fit) {
  return std::sqrt(fit.summary.cost / std::max(1, degrees_of_freedom(fit.bundle)));
}

// A fit of opencv5 rejects right corners of a rational lens. Returns that of opencv8 to all but the
// gross outliers, if this has more inliers and explains all corners better.
CalibrationFit with_most_inliers(CalibrationFit fit, const CalibrationInput& input,
                                 const CalibrateOptions& options) {
  if (!options.reject_outliers || fit.outliers.empty() || fit.whitened) return fit;
  const double sigma = noise_of_residuals(fit);
  CalibrationFit generous = fit;
  std::erase_if(generous.outliers,
                [&](const Outlier& o) { return o.residual_px < policy::kGrossSigmas * sigma; });
  const Bundle rational = with_model(fit.bundle, input.models->named("opencv8"));
  auto more = refit(rational, generous, input, options);
  const bool is_better = more && more->num_inliers() > fit.num_inliers() &&
                         more->truncated_chi_square(sigma) < fit.truncated_chi_square(sigma);
  return is_better ? std::move(*more) : std::move(fit);
}

// opencv5; or, if the data do not determine it, f before it if that has about as many inliers.
std::vector<CalibrationFit> fit_perspectives(const CalibrationInput& input,
                                             const CalibrateOptions& options) {
  std::vector<CalibrationFit> fits;
  for (const char* model : {"opencv5", "f"}) {
    auto fit = fit_model(input.models->named(model), input, options);
    if (!fit) continue;
    if (fit->summary.converged && fits.empty() &&
        observability(fit->bundle, noise_of_residuals(*fit)).status == Status::ok)
      return {with_most_inliers(std::move(*fit), input, options)};
    fits.push_back(std::move(*fit));
  }
  if (fits.size() == 2 &&
      !policy::is_below(fits[1].num_inliers(), policy::kSmallModelInliers, fits[0].num_inliers()))
    std::swap(fits[0], fits[1]);
  return fits;
}

// The fits of both kinds of lens, with rejection of outliers. No value if no view has a consensus.
std::optional<LensFits> fit_lenses(const CalibrationInput& input, const CalibrateOptions& options) {
  LensFits fits{fit_perspectives(input, options),
                fit_model(input.models->named("fisheye4"), input, options)};
  if (fits.perspectives.empty() && !fits.fisheye) return std::nullopt;
  return fits;
}

double start_seconds(const LensFits& fits) {
  double sum = fits.fisheye ? fits.fisheye->start_seconds : 0;
  for (const CalibrationFit& fit : fits.perspectives) sum += fit.start_seconds;
  return sum;
}

void add_supported_models(ModelChoice& choice, const ModelLadder& ladder, const Candidate& chosen,
                          const CalibrateOptions& options) {
  const ResidualBias bias = residual_bias(chosen.bundle, least_sigma(ladder.whitened, options));
  choice.supported = supported_models(ladder, chosen, bias.inflation);
  for (const SupportedModel& supported : choice.supported)
    for (ModelStep& step : choice.steps)
      if (step.model == supported.bundle.model->name()) add_weight(step, supported.weight);
}

// `winner`: null if no candidate is usable; `basis` is then the first one.
void set_status(ModelChoice& choice, const ModelLadder& ladder, const Candidate& basis,
                const Candidate* winner) {
  if (!winner) {
    const bool is_determined = basis.observability.status == Status::ok;
    choice.status = is_determined ? Status::not_converged : basis.observability.status;
    choice.reason =
        is_determined ? "the solver converged for no model" : basis.observability.reason;
  } else if (const Candidate* more = better_but_undetermined(ladder, *winner)) {
    choice.status = Status::not_observable;
    choice.reason = "model " + std::string(winner->model().name()) +
                    " does not explain the corners, and they do not determine model " +
                    std::string(more->model().name()) + ": " + more->observability.reason;
  }
}

// The choice by the three rules. The ladder's fits must be to `input`.
ModelChoice choose(const ModelLadder& ladder, const CalibrationInput& input,
                   const CalibrateOptions& options) {
  std::vector<std::optional<double>> differences(ladder.candidates.size());
  const Candidate* winner = lowest_score(ladder);
  const Candidate* chosen =
      winner ? smallest_equivalent(ladder, *winner, options.tolerance_px, differences) : nullptr;
  const Candidate& basis = chosen ? *chosen : ladder.candidates.front();
  ModelChoice choice{*basis.fit, chosen == nullptr, Status::ok, "", {}, {}};
  if (basis.bundle.free_values != basis.fit->bundle.free_values) {
    if (auto fit = refit(basis.bundle, *basis.fit, input, options)) choice.fit = std::move(*fit);
  }
  continue_until_converged(choice.fit.bundle, choice.fit.summary, options.max_iterations);
  choice.fit.bic = basis.bic;
  choice.steps = model_steps(ladder, chosen, winner, differences);
  if (chosen) add_supported_models(choice, ladder, *chosen, options);
  set_status(choice, ladder, basis, winner);
  return choice;
}

std::optional<ModelChoice> choose_on_all_views(const CalibrationInput& input,
                                               const CalibrateOptions& options) {
  const std::optional<LensFits> fits = fit_lenses(input, options);
  if (!fits) return std::nullopt;
  ModelChoice choice = choose(fit_ladder(*fits, false, options), input, options);
  choice.fit.start_seconds = start_seconds(*fits);
  return choice;
}

// The best candidate of the other kind of lens, if `best` is not better by strong evidence.
const Candidate* rival_kind(const ModelLadder& ladder, const Candidate& best) {
  const Candidate* rival = nullptr;
  for (const Candidate& other : ladder.candidates)
    if (other.is_fisheye() != best.is_fisheye() && other.is_usable() &&
        score(other, ladder) < score(best, ladder) + policy::kStrongEvidence &&
        (!rival || other.bic < rival->bic))
      rival = &other;
  return rival;
}

std::optional<CalibrationFit> fit_from(const Candidate& start, const CalibrationInput& input,
                                       CalibrateOptions options) {
  options.start = Camera{start.bundle.lens(), input.image_size};
  return fit_model(start.model(), input, options);
}

// Fits the winner of a few views to all of them, and those models that may still win. No value if
// the few views determine no model, or all of them leave a doubt.
std::optional<ModelChoice> choose_from_few_views(const CalibrationInput& input,
                                                 const CalibrateOptions& options) {
  const auto fits = fit_lenses(spread_views(input, policy::kChoiceViews), options);
  if (!fits) return std::nullopt;
  const ModelLadder few = fit_ladder(*fits, true, options);
  const Candidate* best = lowest_score(few);
  if (!best || better_but_undetermined(few, *best)) return std::nullopt;
  const auto fit = fit_from(*best, input, options);
  if (!fit) return std::nullopt;
  const Candidate* rival = rival_kind(few, *best);
  const auto rival_fit = rival ? fit_from(*rival, input, options) : std::nullopt;
  ModelChoice choice = choose(
      fit_contenders(few, *best, *fit, rival_fit ? &*rival_fit : nullptr, options), input, options);
  if (choice.status != Status::ok) return std::nullopt;
  choice.fit.start_seconds = start_seconds(*fits) + fit->start_seconds;
  return choice;
}

}  // namespace

std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const auto begin = Clock::now();
  std::optional<ModelChoice> choice;
  if (input.views.size() > policy::kChoiceViews) choice = choose_from_few_views(input, options);
  if (!choice) choice = choose_on_all_views(input, options);
  if (choice)
    choice->fit.solve_seconds =
        std::chrono::duration<double>(Clock::now() - begin).count() - choice->fit.start_seconds;
  return choice;
}

}  // namespace tagcal::internal
