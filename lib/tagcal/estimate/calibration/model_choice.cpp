#include "tagcal/estimate/calibration/model_choice.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/lens_from_rays.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration_diff.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// A candidate for the answer: a component of the posterior, or another kind of lens.
struct Candidate {
  Component component;
  double bic = 0;
  bool is_nested = false;  // in the posterior's model: it can be the answer
};

// chi-square of all corners, each up to the rejection bound, and of the priors, for the noise of
// `noise`; with what the evidence charges for row terms.
double chi_square(const CalibrationFit& fit, const Posterior& noise) {
  const double sigma = noise.noise.sigma;
  const double sum = fit.truncated_chi_square(sigma) + fit.summary.prior / (sigma * sigma);
  return sum / noise.covariance.overdispersion + fit.summary.row_volume;
}

// The number of independent residuals.
double num_residuals(const Posterior& posterior) {
  return 2.0 * posterior.fit.num_corners / posterior.covariance.overdispersion;
}

double bic(const Model& model, double chi_square, const Posterior& posterior) {
  return chi_square + model.num_free() * std::log(num_residuals(posterior));
}

std::optional<Posterior> fit_posterior(const Model& model, const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  auto fit = fit_model(model, input, options);
  return fit ? posterior_of(std::move(*fit), options) : std::nullopt;
}

// The posteriors of the kinds of lens on the same views.
struct Kinds {
  std::optional<Posterior> polynomial, rational, fisheye;

  std::vector<const Posterior*> all() const {
    std::vector<const Posterior*> result;
    for (const auto* kind : {&polynomial, &rational, &fisheye})
      if (*kind) result.push_back(&**kind);
    return result;
  }
};

// The free values of a model whose lens is nearest to a solved one where the corners are.
std::vector<double> nearest_values(const Model& model, const Bundle& solved) {
  const Lens lens = solved.lens();
  Sightings seen;
  for (const Eigen::Vector2d& pixel : seen_region(solved).samples())
    if (const auto ray = ray_in_camera(lens, pixel)) seen.add(pixel, ray->direction);
  const auto p = parameters(lens);
  const auto nearest = lens_from_rays(model, solved.image_size, seen,
                                      Eigen::Vector2d(p[kCx], p[kCy]), {model.free_values(lens)});
  return nearest ? nearest->free_values : model.free_values(lens);
}

// A perspective without the denominator of its distortion, on the same inliers.
std::optional<Posterior> polynomial_of(const Posterior& rational, const CalibrationInput& input,
                                       const CalibrateOptions& options) {
  const Model& model = input.models->named("opencv5");
  return posterior_of(
      fit_on_inliers(rational.fit, model, nearest_values(model, rational.fit.bundle), options),
      options);
}

Kinds fit_kinds(const CalibrationInput& input, const CalibrateOptions& options) {
  Kinds kinds;
  kinds.rational = fit_posterior(input.models->named("opencv8"), input, options);
  if (kinds.rational) kinds.polynomial = polynomial_of(*kinds.rational, input, options);
  kinds.fisheye = fit_posterior(input.models->named("fisheye4"), input, options);
  return kinds;
}

// The posterior of the lowest BIC. A fisheye is charged policy::kFisheyeCharge parameters more than
// a polynomial: where both describe the same images, the ordinary lens is meant.
const Posterior* best_of(const Kinds& kinds) {
  const Posterior* noise = nullptr;
  for (const Posterior* kind : kinds.all())
    if (!noise || chi_square(kind->fit, *kind) < chi_square(noise->fit, *kind)) noise = kind;
  if (!noise) return nullptr;
  const auto score = [&](const std::optional<Posterior>& p) {
    return p ? bic(p->model(), chi_square(p->fit, *noise), *noise)
             : std::numeric_limits<double>::infinity();
  };
  const bool is_polynomial = score(kinds.polynomial) <= score(kinds.rational);
  const std::optional<Posterior>& usual = is_polynomial ? kinds.polynomial : kinds.rational;
  const double charge =
      is_polynomial ? policy::kFisheyeCharge * std::log(num_residuals(*noise)) : 0;
  if (kinds.fisheye && score(kinds.fisheye) + charge < score(usual)) return &*kinds.fisheye;
  return usual ? &*usual : nullptr;
}

// Weights of the components: exp(-(chi-square - occam) / 2).
void set_weights(std::vector<Candidate>& candidates) {
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  const auto score = [](const Candidate& c) { return c.component.chi_square - c.component.occam; };
  for (const Candidate& c : candidates) least = std::min(least, score(c));
  for (Candidate& c : candidates) sum += c.component.weight = std::exp((least - score(c)) / 2);
  double kept = 0;
  for (Candidate& c : candidates) {
    c.component.weight /= sum;
    if (c.component.weight < policy::kLeastModelWeight) c.component.weight = 0;
    kept += c.component.weight;
  }
  for (Candidate& c : candidates) c.component.weight /= kept;
}

// The posterior of another kind on the same views as `same`, as a component of `posterior`, which
// may have more views: the difference of chi-square grows with their number. Both kinds are
// approximations of a real lens, so their odds are weaker than those of nested models.
std::optional<Component> other_kind(const Posterior& kind, const Posterior& same,
                                    const Posterior& posterior) {
  auto component = as_seen_by(kind, same);
  if (!component) return std::nullopt;
  const double growth = static_cast<double>(posterior.fit.num_corners) / same.fit.num_corners;
  const double more = chi_square(kind.fit, same) - chi_square(same.fit, same);
  const bool is_other_lens = kind.model().lens_type() != posterior.model().lens_type();
  const double temper = is_other_lens ? policy::kKindTemper : 1;
  component->chi_square = (more > 0 ? growth * more : more) / temper;  // noise does not grow
  component->occam = (occam(same) - occam(kind)) / temper;
  component->values += posterior.values() - same.values();
  component->covariance /= growth;
  return component;
}

// The components of a posterior: the models nested in it, and the other kinds. `same`: the
// posterior of its model among the kinds.
std::vector<Candidate> candidates_of(const Posterior& posterior, const Kinds& kinds,
                                     const Posterior& same) {
  std::vector<Candidate> candidates;
  for (const Model* model : posterior.model().siblings()) {
    if (model->lens_type() == LensType::parallel) continue;
    if (auto component = nested_in(posterior, *model))
      candidates.push_back({std::move(*component), 0, true});
  }
  for (const Posterior* kind : kinds.all())
    if (kind != &same && !nested_in(posterior, kind->model()))
      if (auto component = other_kind(*kind, same, posterior))
        candidates.push_back({std::move(*component), 0, false});
  for (Candidate& c : candidates)
    c.bic = bic(*c.component.model, c.component.chi_square, posterior);
  set_weights(candidates);
  return candidates;
}

std::optional<Lens> lens_of(const Component& component, const Posterior& posterior) {
  const Index k = posterior.model().num_free();
  const VectorXd values = component.values.head(k);
  return posterior.model().lens(std::vector<double>(values.begin(), values.end()),
                                posterior.fit.bundle.image_size);
}

// The Jacobian of the projection over the region of the corners, by the posterior's lens.
Eigen::MatrixXd projection_of(const Posterior& posterior, double distance_m) {
  return aligned_jacobian({&posterior.model(), posterior.fit.bundle.lens(), {}},
                          seen_region(posterior.fit.bundle).samples(), distance_m);
}

// The projections of a component and of the mean differ by at most policy::kAgreeingSigmas of the
// claim over the region of the corners.
bool agrees(const Component& component, const VectorXd& mean, const Eigen::MatrixXd& covariance,
            const Eigen::MatrixXd& projection) {
  const Index k = projection.cols();
  const VectorXd d = projection * (component.values - mean).head(k);
  for (Index row = 0; row + 1 < projection.rows(); row += 2) {
    const auto rows = projection.middleRows<2>(row);
    const double variance = (rows * covariance.topLeftCorner(k, k)).cwiseProduct(rows).sum();
    if (!(d.segment<2>(row).norm() <= policy::kAgreeingSigmas * std::sqrt(variance))) return false;
  }
  return true;
}

// The claim of the components about their mean.
struct Mean {
  VectorXd values;
  Eigen::MatrixXd covariance;
};

std::vector<Component> components_of(const std::vector<Candidate>& candidates) {
  std::vector<Component> components;
  for (const Candidate& c : candidates) components.push_back(c.component);
  return components;
}

Mean mean_of(const std::vector<Candidate>& candidates) {
  const std::vector<Component> components = components_of(candidates);
  Mean mean{VectorXd::Zero(components.front().values.size()), {}};
  for (const Component& c : components) mean.values += c.weight * c.values;
  mean.covariance = mixture_about(mean.values, components);
  return mean;
}

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
  CalibrationFit copy{fit.bundle, fit.views, fit.images, fit.whitened, fit.summary};
  copy.num_corners = fit.num_corners;
  copy.num_iterations = fit.num_iterations;
  copy.outliers = fit.outliers;
  copy.findings = fit.findings;
  copy.bic = fit.bic;
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
    const Mean mean = mean_of(candidates);
    if (!answer.fit.summary.converged ||
        !agrees(c.component, mean.values, mean.covariance, projection))
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
    if (component.model->lens_type() != posterior.model().lens_type() ||
        component.model->num_free() >= most || !lens_of(component, posterior))
      continue;
    Answer smaller{i, refit(candidates[i], posterior, options)};
    const auto d = lens_difference({best.fit.bundle.lens(), size},
                                   {smaller.fit.bundle.lens(), size}, samples, distance_m);
    if (d && d->rms_px <= options.tolerance_px) return smaller;
  }
  return best;
}

// RMS of a projection's change by a change of the parameters, as the length in pixels.
double rms_px(const Eigen::MatrixXd& projection, const VectorXd& change) {
  const double pixels = std::max<double>(1, static_cast<double>(projection.rows()) / 2);
  return std::sqrt((projection * change.head(projection.cols())).squaredNorm() / pixels);
}

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

// Steps of the models nested in a perspective, whose kind lost against the posterior's. `more`: the
// chi-square of that kind above the posterior's.
std::vector<ModelStep> steps_of_loser(const Posterior& loser, double more,
                                      const Posterior& posterior) {
  std::vector<ModelStep> steps;
  for (const Model* model : loser.model().siblings()) {
    if (model->lens_type() == LensType::parallel || model == &loser.model()) continue;
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

// The claim of a covariance of the parameters, and of the poses by it.
BundleCovariance claim_of(const Eigen::MatrixXd& all, const Posterior& posterior) {
  BundleCovariance claim = posterior.covariance;
  const Eigen::MatrixXd own = claim.all;
  claim.all = all;
  const Index k = posterior.model().num_free();
  claim.parameters = claim.all.topLeftCorner(k, k);
  for (std::size_t v = 0; v < claim.poses.size(); ++v) {
    const Eigen::MatrixXd& by = posterior.information.views[v].pose_by_parameters;
    claim.poses[v] += by * (claim.all - own) * by.transpose();
  }
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
    choice.fit.bic = candidates[answer.index].bic;
    choice.steps = steps_of(candidates, answer.index, posterior);
    if (posterior.model().lens_type() == LensType::fisheye) {
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

// All corners are within 80 degrees of the axis, so a perspective lens can see them.
bool within_perspective_field(const Bundle& bundle) {
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const Correspondence& c : bundle.views[v].correspondences) {
      const Eigen::Vector3d x = bundle.camera_from_target[v] * c.point;
      if (x.z() < policy::kPerspectiveCosine * x.norm()) return false;
    }
  return true;
}

// The share of chi-square that opencv5 explains beyond a fisheye that the user named, on at most
// policy::kChoiceViews views; 0 if that is chance.
double gain_of_perspective(const Posterior& named, const CalibrationInput& input,
                           const CalibrateOptions& options) {
  if (named.model().lens_type() != LensType::fisheye || !within_perspective_field(named.fit.bundle))
    return 0;
  const CalibrationInput few = spread_views(input, policy::kChoiceViews);
  const auto fisheye = fit_posterior(named.model(), few, options);
  const auto other = fit_posterior(input.models->named("opencv5"), few, options);
  if (!fisheye || !other) return 0;
  const double own = chi_square(fisheye->fit, *other), less = chi_square(other->fit, *other);
  return own - less > policy::kOtherLensChiSquare ? (own - less) / own : 0;
}

std::vector<std::size_t> spread_indices(std::size_t n, std::size_t count) {
  std::vector<std::size_t> indices(std::min(n, count));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * n / indices.size();
  return indices;
}

}  // namespace

CalibrationInput spread_views(const CalibrationInput& input, std::size_t count) {
  CalibrationInput few = input;
  few.views.clear();
  for (const std::size_t v : spread_indices(input.views.size(), count))
    few.views.push_back(input.views[v]);
  return few;
}

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
  const bool is_part = input.views.size() > policy::kChoiceViews;
  const Kinds kinds =
      fit_kinds(is_part ? spread_views(input, policy::kChoiceViews) : input, options);
  const Posterior* best = best_of(kinds);
  if (!best) return std::nullopt;
  if (!is_part) return choose(*best, kinds, *best, options);
  CalibrateOptions from = options;
  from.start = Camera{best->fit.bundle.lens(), input.image_size};
  auto all = fit_posterior(best->model(), input, from);
  if (!all) return std::nullopt;
  return choose(std::move(*all), kinds, *best, options);
}

}  // namespace tagcal::internal
