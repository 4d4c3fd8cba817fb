#include "tagcal/estimate/calibration/model_choice.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/candidates.hpp"
#include "tagcal/estimate/calibration/model_steps.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::VectorXd;

// A candidate for the answer, refitted.
struct Answer {
  std::size_t index = 0;  // of the candidate
  CalibrationFit fit;
};

// The candidate of the lowest BIC that may be the answer.
std::optional<std::size_t> lowest_bic(const std::vector<Candidate>& candidates,
                                      const Posterior& posterior) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].is_nested && lens_of(candidates[i].component, posterior) &&
        (!best || candidates[i].bic < candidates[*best].bic))
      best = i;
  return best;
}

// The squares of all corners, which the posterior's fit keeps, are much of the memory.
CalibrationFit without_squares(const CalibrationFit& fit) {
  CalibrationFit copy{fit.bundle, fit.used, fit.selection, {}, fit.whitened, fit.summary};
  copy.num_corners = fit.num_corners;
  copy.num_iterations = fit.num_iterations;
  copy.findings = fit.findings;
  copy.start_seconds = fit.start_seconds;
  copy.solve_seconds = fit.solve_seconds;
  return copy;
}

// Refits a candidate, whose values and chi-square were predictions.
CalibrationFit refit(Candidate& c, const Posterior& posterior, const CalibrateOptions& options) {
  if (c.component.model == &posterior.model()) return without_squares(posterior.fit);
  const Lens start = *lens_of(c.component, posterior);
  CalibrationFit fit = fit_on_inliers(without_squares(posterior.fit), *c.component.model,
                                      c.component.model->free_values(start), options);
  const double variance = posterior.noise.sigma * posterior.noise.sigma;
  const double more = fit.summary.cost + fit.summary.prior - posterior.fit.summary.cost -
                      posterior.fit.summary.prior;
  const std::vector<double> free = posterior.model().free_values(fit.bundle.lens());
  c.component.values.head(posterior.model().num_free()) =
      Eigen::Map<const VectorXd>(free.data(), std::ssize(free));
  if (fit.bundle.board) c.component.values.tail<4>() = fit.bundle.shape;
  c.component.chi_square = std::max(0.0, more) / variance / posterior.covariance.overdispersion;
  c.bic = bic(*c.component.model, c.component.chi_square, posterior);
  return fit;
}

// The candidate of the lowest BIC that agrees with the mean. A refit may make another one the
// lowest.
Answer answer_of(std::vector<Candidate>& candidates, const Posterior& posterior,
                 const CalibrateOptions& options) {
  const Eigen::MatrixXd projection = projection_of(posterior, kInfinitelyFar);
  std::vector<bool> is_tried(candidates.size());
  while (const std::optional<std::size_t> i = lowest_bic(candidates, posterior)) {
    Candidate& c = candidates[*i];
    Answer answer{*i, refit(c, posterior, options)};
    if (c.component.model == &posterior.model() || is_tried[*i]) return answer;
    is_tried[*i] = true;
    set_weights(candidates);
    if (!answer.fit.summary.converged || !agrees(c.component, mean_of(candidates), projection))
      c.is_nested = false;
    else if (lowest_bic(candidates, posterior) == i)
      return answer;
  }
  return {candidates.size(), without_squares(posterior.fit)};
}

// The smallest candidate whose projection is within the tolerance of that of `best`, or `best`.
Answer smallest_within(Answer best, std::vector<Candidate>& candidates, const Posterior& posterior,
                       const CalibrateOptions& options) {
  const ImageSize& size = posterior.fit.bundle.image_size;
  const auto samples = seen_region(posterior.fit.bundle).samples();
  const double distance_m = median_distance_m(posterior.fit.bundle);
  const int most = best.fit.bundle.model->num_free();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Component& component = candidates[i].component;
    if (&component.model->kind() != &posterior.model().kind() ||
        component.model->num_free() >= most || !lens_of(component, posterior))
      continue;
    Answer smaller{i, refit(candidates[i], posterior, options)};
    const auto d = lens_difference({best.fit.bundle.lens(), size},
                                   {smaller.fit.bundle.lens(), size}, samples, distance_m);
    if (d && d->rms_px <= options.tolerance_px) return smaller;
  }
  return best;
}

// The claim of a covariance of the parameters, and of the poses by it.
BundleCovariance claim_of(const Eigen::MatrixXd& all, const Posterior& posterior) {
  BundleCovariance claim = posterior.covariance;
  replace_covariance(claim, all, posterior.information);
  return claim;
}

// `same`: the posterior of its model among the kinds.
ModelChoice choose(Posterior posterior, const Kinds& kinds, const Posterior& same,
                   const CalibrateOptions& options) {
  ModelChoice choice;
  std::vector<Candidate> candidates = candidates_of(posterior, kinds, same);
  Answer answer = answer_of(candidates, posterior, options);
  if (options.tolerance_px > 0)
    answer = smallest_within(std::move(answer), candidates, posterior, options);
  choice.fit = std::move(answer.fit);
  VectorXd values = posterior.values();
  if (answer.index < candidates.size()) {
    values = candidates[answer.index].component.values;
    choice.steps = steps_of(candidates, answer.index, posterior);
    if (posterior.model().kind().reaches_behind) {
      const auto& loser = kinds.rational ? kinds.rational : kinds.polynomial;
      if (loser) {
        const double more = chi_square(loser->fit, same) - chi_square(same.fit, same);
        auto steps = steps_of_loser(*loser, more, posterior);
        choice.steps.insert(choice.steps.begin(), steps.begin(), steps.end());
      }
    }
  }
  const Eigen::MatrixXd mixture = mixture_about(values, components_of(candidates));
  const Eigen::MatrixXd& own =
      answer.index < candidates.size() ? candidates[answer.index].component.covariance : mixture;
  choice.claim = claim_of(mixture + curvature_of(choice.fit, own, posterior), posterior);
  choice.posterior = std::move(posterior);
  return choice;
}

}  // namespace

std::optional<ModelChoice> fit_named(const CalibrationInput& input,
                                     const CalibrateOptions& options) {
  auto posterior = fit_posterior(input.models->named(options.model), input, options);
  if (!posterior) return std::nullopt;
  ModelChoice choice;
  choice.fit = without_squares(posterior->fit);
  choice.other_lens_share = gain_of_perspective(*posterior, input, options);
  const Eigen::MatrixXd& own = posterior->covariance.all;
  choice.claim = claim_of(own + curvature_of(choice.fit, own, *posterior), *posterior);
  choice.posterior = std::move(*posterior);
  return choice;
}

std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options) {
  const Kinds kinds = fit_kinds(spread_views(input, policy::kChoiceViews), options);
  const Posterior* best = best_of(kinds);
  if (!best) return std::nullopt;
  if (input.views.size() <= policy::kChoiceViews) return choose(*best, kinds, *best, options);
  auto all = fit_posterior_from(best->fit.bundle.lens(), best->model(), input, options);
  if (!all) return std::nullopt;
  return choose(std::move(*all), kinds, *best, options);
}

}  // namespace tagcal::internal
