#include "tagcal/estimate/calibration/model_steps.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::VectorXd;

// RMS of a projection's change by a change of the parameters, as the length in pixels.
double rms_px(const Eigen::MatrixXd& projection, const VectorXd& change) {
  const double pixels = std::max<double>(1, static_cast<double>(projection.rows()) / 2);
  return std::sqrt((projection * change.head(projection.cols())).squaredNorm() / pixels);
}

}  // namespace

std::vector<ModelStep> steps_of(const std::vector<Candidate>& candidates, std::size_t answer,
                                const Posterior& posterior) {
  std::vector<ModelStep> steps;
  const auto lowest = std::ranges::min_element(candidates, {}, &Candidate::bic);
  const Eigen::MatrixXd projection =
      projection_of(posterior, median_distance_m(posterior.fit.bundle));
  const double variance = posterior.noise.sigma * posterior.noise.sigma;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Component& c = candidates[i].component;
    ModelStep step;
    step.model = c.model->name();
    step.num_parameters = c.model->num_free();
    step.cost =
        posterior.fit.summary.cost + variance * posterior.covariance.overdispersion * c.chi_square;
    step.bic = candidates[i].bic;
    step.weight = c.weight;
    step.taken = i == answer;
    step.difference_px = rms_px(projection, c.values - lowest->component.values);
    const double more = candidates[i].bic - candidates[answer].bic;
    step.sentence = step.taken ? "taken: the lowest BIC of the models that agree with the posterior"
                    : more < 0 ? "not taken: its projection disagrees with the posterior"
                               : "not taken: its BIC is higher by " + with_digits(more, 3);
    if (c.weight > 0)
      step.sentence += "; has " + percent(c.weight) + " of the weight in the standard deviations";
    steps.push_back(std::move(step));
  }
  return steps;
}

std::vector<ModelStep> steps_of_loser(const Posterior& loser, double more,
                                      const Posterior& posterior) {
  std::vector<ModelStep> steps;
  for (const Model* model : loser.model().siblings()) {
    if (!model->kind().is_central || model == &loser.model()) continue;
    const auto nested = nested_in(loser, *model);
    if (!nested) continue;
    ModelStep step;
    step.model = model->name();
    step.num_parameters = model->num_free();
    step.bic = bic(*model, more + nested->chi_square, posterior);
    step.sentence = "not taken: another kind of lens explains the corners better";
    steps.push_back(std::move(step));
  }
  return steps;
}

}  // namespace tagcal::internal
