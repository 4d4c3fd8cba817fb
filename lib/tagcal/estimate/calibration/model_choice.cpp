#include "tagcal/estimate/calibration/model_choice.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/bundle/convergence.hpp"
#include "tagcal/estimate/bundle/residual_bias.hpp"
#include "tagcal/estimate/calibration/model_ladder.hpp"
#include "tagcal/estimate/calibration/weak_calibration.hpp"
#include "tagcal/estimate/calibration_diff.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector2d;

constexpr double kGrosslyWrongSigmas = 100;
constexpr int kFisheyeHandicap = 3;     // parameters
constexpr double kStrongEvidence = 10;  // of BIC (Kass & Raftery 1995: very strong)

std::string number(double value) {
  char text[64];
  std::snprintf(text, sizeof text, std::abs(value) < 1000 ? "%.3g" : "%.0f", value);
  return text;
}

bool is_fisheye(const Rung& rung) { return rung.model().lens_type() == LensType::fisheye; }

// Against polynomials; the rational lens bends as freely.
double handicap(const Ladder& ladder) {
  const Rung* best = nullptr;
  for (const Rung& rung : ladder.rungs)
    if (!is_fisheye(rung) && rung.holds() && (!best || rung.bic < best->bic)) best = &rung;
  const bool is_rational = best && best->model().name() == "opencv8";
  return is_rational ? 0 : kFisheyeHandicap * std::log(ladder.num_residuals);
}

double score(const Rung& rung, const Ladder& ladder) {
  return rung.bic + (is_fisheye(rung) ? handicap(ladder) : 0);
}

// The fisheye is no way out for data that hold too little of a perspective: it must beat them all,
// held or not.
bool stands_for_choice(const Rung& rung, const Ladder& ladder) {
  if (!rung.holds() || !is_fisheye(rung)) return rung.holds();
  return std::all_of(ladder.rungs.begin(), ladder.rungs.end(), [&](const Rung& other) {
    return score(rung, ladder) <= score(other, ladder);
  });
}

const Rung* lowest_score(const Ladder& ladder) {
  const Rung* best = nullptr;
  for (const Rung& rung : ladder.rungs)
    if (stands_for_choice(rung, ladder) && (!best || score(rung, ladder) < score(*best, ladder)))
      best = &rung;
  return best;
}

// The region over which, and the distance at which, projections are compared.
struct Comparison {
  std::vector<Vector2d> samples;
  double distance_m = 1;

  explicit Comparison(const Bundle& bundle)
      : samples(seen_region(bundle).samples()), distance_m(median_distance_m(bundle)) {}
};

ProjectionUncertainty uncertainty(const Rung& rung, const Comparison& at) {
  return projection_uncertainty(
      {&rung.model(), rung.bundle.lens(), rung.seen.covariance->parameters},
      ImageGrid{rung.bundle.image_size}, at.samples, at.distance_m);
}

// Whether the smaller model projects as the larger one does, at every node of the image within the
// larger one's standard deviation there (per coordinate); a node that only one of them sees is a
// difference.
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

bool stands_for(const Rung& small, const Rung& large, const Comparison& at, double tolerance_px,
                double& difference_px) {
  const Camera a{large.bundle.lens(), large.bundle.image_size};
  const Camera b{small.bundle.lens(), small.bundle.image_size};
  const auto d = lens_difference(a, b, at.samples, at.distance_m);
  if (!d) return false;
  difference_px = d->rms_px;
  return d->rms_px <= tolerance_px || agrees_everywhere(uncertainty(large, at), *d);
}

const Rung* simplified(const Ladder& ladder, const Rung& winner, double tolerance_px,
                       std::vector<std::optional<double>>& differences) {
  if (is_fisheye(winner)) return &winner;
  const Comparison at(winner.bundle);
  const Rung* simplest = nullptr;
  for (std::size_t i = 0; i < ladder.rungs.size(); ++i) {
    const Rung& rung = ladder.rungs[i];
    if (&rung == &winner || !rung.holds() || is_fisheye(rung)) continue;
    double difference = 0;
    const bool alike = stands_for(rung, winner, at, tolerance_px, difference);
    differences[i] = difference;
    const bool smaller = rung.model().num_free() < winner.model().num_free();
    if (alike && smaller && !simplest) simplest = &rung;
  }
  return simplest ? simplest : &winner;
}

// A model that the data ask for and do not determine.
const Rung* wanted(const Ladder& ladder, const Rung& winner) {
  for (const Rung& rung : ladder.rungs) {
    const bool undetermined = rung.seen.status != Status::ok;
    if (!undetermined || !rung.summary.converged || is_fisheye(rung) || is_fisheye(winner))
      continue;
    if (rung.bic < winner.bic - kStrongEvidence) return &rung;
  }
  return nullptr;
}

ModelStep weak_step(const Ladder& ladder, bool taken) {
  ModelStep step;
  step.model = "weak";
  step.taken = taken;
  step.sentence = taken ? "the data hold no more" : "not needed: the data hold a focal length";
  const Bundle& bundle = ladder.rungs.front().bundle;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto view = fit_weak_view(bundle.views[v], image_centre(bundle.image_size),
                                    bundle.camera_from_target[v]);
    if (view) step.cost += view->cost;
  }
  step.bic = step.cost / ladder.noise_square;
  return step;
}

// The sentence of a model beside the last one that was taken, or what was chosen instead (none:
// the first).
std::string why(const Rung& rung, const Rung* last, const Ladder& ladder, bool taken) {
  if (rung.seen.status != Status::ok)
    return "not taken, the data cannot hold it: " + rung.seen.reason;
  if (!rung.summary.converged) return "not taken: the solution did not converge";
  if (rung.has_pole) return "not taken: its distortion has a pole inside the image";
  if (!last || last == &rung) return taken ? "taken: the data hold its parameters" : "not taken";
  const double gain = (last->misfit - rung.misfit) * ladder.noise_square;
  const int more = rung.model().num_free() - last->model().num_free();
  std::string text = number(std::abs(gain)) + (ladder.whitened ? "" : " px^2") +
                     (gain >= 0 ? " better than " : " worse than ") +
                     std::string(last->model().name()) + " in " +
                     std::to_string(ladder.num_residuals) + " residuals";
  if (more > 0)
    text += ", for " + std::to_string(more) + (more == 1 ? " parameter" : " parameters");
  if (more > 0) text += " more";
  return text + (taken ? ": taken" : ": not needed");
}

std::vector<ModelStep> explain(const Ladder& ladder, const Rung* chosen, const Rung* winner,
                               const std::vector<std::optional<double>>& differences) {
  std::vector<ModelStep> steps = {weak_step(ladder, chosen == nullptr)};
  const Rung* last = nullptr;
  bool done = chosen == nullptr;
  const double chosen_difference =
      chosen ? differences[static_cast<std::size_t>(chosen - ladder.rungs.data())].value_or(0) : 0;
  for (std::size_t i = 0; i < ladder.rungs.size(); ++i) {
    const Rung& rung = ladder.rungs[i];
    ModelStep step;
    step.model = rung.model().name();
    step.num_parameters = rung.model().num_free();
    step.cost = rung.misfit * ladder.noise_square;
    step.bic = rung.bic;
    step.difference_px = differences[i];
    const bool on_the_way = chosen && !done && rung.holds() && !is_fisheye(rung) &&
                            !is_fisheye(*chosen) && (!last || rung.bic < last->bic);
    step.taken = &rung == chosen || on_the_way;
    step.sentence = why(rung, last || step.taken ? last : chosen, ladder, step.taken);
    if (&rung == winner && winner != chosen)
      step.sentence += ", the projections differ by " + number(chosen_difference) + " px";
    if (step.taken) last = &rung;
    done |= &rung == chosen;
    steps.push_back(std::move(step));
  }
  return steps;
}

void add_weight(ModelStep& step, double weight) {
  step.weight = weight;
  if (weight > kWorthAWord) step.sentence += "; counts " + percent(weight) + " in what is claimed";
}

// Corners that only the rational lens reaches must not be lost to it: it gets a try at those which
// the fit left out, but for the grossly wrong ones. Wrong corners that it bends to are no gain.
CalibrationFit with_rational_corners(const CalibrationFit& fit, double sigma,
                                     const CalibrationInput& input,
                                     const CalibrateOptions& options) {
  if (!options.reject_outliers || fit.outliers.empty() || fit.whitened) return fit;
  CalibrationFit generous = fit;
  std::erase_if(generous.outliers,
                [&](const Outlier& o) { return o.residual_px < kGrosslyWrongSigmas * sigma; });
  Bundle rational = fit.bundle;
  rational.model = &input.models->named("opencv8");
  rational.free_values = rational.model->free_values(fit.bundle.lens());
  std::optional<CalibrationFit> more = refit(rational, generous, input, options);
  const bool better = more && more->num_inliers() > fit.num_inliers() &&
                      more->truncated_misfit(sigma) < fit.truncated_misfit(sigma);
  return better ? std::move(*more) : fit;
}

struct PerspectiveFits {
  std::optional<CalibrationFit> chosen;
  std::optional<CalibrationFit> other;
};

// The corners that all perspectives are held against: those of the largest, or of the smallest
// where the largest is more than the data hold and the smallest explains as many.
PerspectiveFits fit_perspectives(const CalibrationInput& input, const CalibrateOptions& options) {
  std::optional<CalibrationFit> large = fit_model(input.models->named("opencv5"), input, options);
  if (large && large->summary.converged) {
    const int freedom = std::max(1, degrees_of_freedom(large->bundle));
    const double sigma = std::sqrt(large->summary.cost / freedom);
    if (observability(large->bundle, sigma).status == Status::ok)
      return {with_rational_corners(*large, sigma, input, options), std::nullopt};
  }
  std::optional<CalibrationFit> small = fit_model(input.models->named("f"), input, options);
  const bool is_enough = small && !(large && 20 * small->num_inliers() < 19 * large->num_inliers());
  if (is_enough) std::swap(small, large);
  return {std::move(large), std::move(small)};
}

void count_supported(ModelChoice& choice, const Ladder& ladder, const Rung& chosen,
                     const CalibrateOptions& options) {
  const ResidualField field = residual_field(chosen.bundle, least_sigma(ladder.whitened, options));
  choice.supported = supported_models(ladder, chosen, field.inflation);
  for (const SupportedModel& supported : choice.supported)
    for (ModelStep& step : choice.steps)
      if (step.model == supported.bundle.model->name()) add_weight(step, supported.weight);
}

// `winner`: null where nothing but the basis is left.
void judge(ModelChoice& choice, const Ladder& ladder, const Rung& basis, const Rung* winner) {
  if (!winner) {
    const bool held = basis.seen.status == Status::ok;
    choice.status = held ? Status::not_converged : basis.seen.status;
    choice.reason = held ? "no model's solution converged" : basis.seen.reason;
  } else if (const Rung* more = wanted(ladder, *winner)) {
    choice.status = Status::not_observable;
    choice.reason = "the corners show more than model " + std::string(winner->model().name()) +
                    " explains, but they do not determine " + std::string(more->model().name()) +
                    ": " + more->seen.reason;
  }
}

}  // namespace

std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const auto begin = Clock::now();
  const PerspectiveFits perspectives = fit_perspectives(input, options);
  const auto& perspective = perspectives.chosen;
  const auto fisheye = fit_model(input.models->named("fisheye4"), input, options);
  if (!perspective && !fisheye) return std::nullopt;
  const auto pointer = [](const std::optional<CalibrationFit>& fit) {
    return fit ? &*fit : nullptr;
  };
  const Ladder ladder =
      build_ladder({pointer(perspective), pointer(fisheye), pointer(perspectives.other)}, options);
  std::vector<std::optional<double>> differences(ladder.rungs.size());
  const Rung* winner = lowest_score(ladder);
  const Rung* chosen =
      winner ? simplified(ladder, *winner, options.tolerance_px, differences) : nullptr;
  const Rung& basis = chosen ? *chosen : ladder.rungs.front();
  std::optional<CalibrationFit> fit = refit(basis.bundle, *basis.fit, input, options);
  if (fit) settle(fit->bundle, fit->summary, options.max_iterations);
  ModelChoice choice{fit ? std::move(*fit) : *basis.fit, chosen == nullptr, Status::ok, "", {}, {}};
  choice.fit.bic = basis.bic;
  choice.fit.start_seconds =
      (perspective ? perspective->start_seconds : 0) + (fisheye ? fisheye->start_seconds : 0);
  choice.fit.solve_seconds =
      std::chrono::duration<double>(Clock::now() - begin).count() - choice.fit.start_seconds;
  choice.steps = explain(ladder, chosen, winner, differences);
  if (chosen) count_supported(choice, ladder, *chosen, options);
  judge(choice, ladder, basis, winner);
  return choice;
}

}  // namespace tagcal::internal
