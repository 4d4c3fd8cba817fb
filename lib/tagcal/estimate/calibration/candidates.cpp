#include "tagcal/estimate/calibration/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The posterior of another kind on the same views as `same`, as a component of `posterior`, which
// may have more views: the difference of chi-square grows with their number. Both kinds are
// approximations of a real lens, so their odds are weaker than those of nested models.
std::optional<Component> other_kind(const Posterior& kind, const Posterior& same,
                                    const Posterior& posterior) {
  auto component = as_seen_by(kind, same);
  if (!component) return std::nullopt;
  const double growth = static_cast<double>(posterior.fit.num_corners) / same.fit.num_corners;
  const double more = chi_square(kind.fit, same) - chi_square(same.fit, same);
  const bool is_other_lens = &kind.model().kind() != &posterior.model().kind();
  const double temper = is_other_lens ? policy::kKindTemper : 1;
  component->chi_square = (more > 0 ? growth * more : more) / temper;  // noise does not grow
  component->occam = (occam(same) - occam(kind)) / temper;
  component->values += posterior.values() - same.values();
  component->covariance /= growth;
  return component;
}

}  // namespace

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

std::vector<Candidate> candidates_of(const Posterior& posterior, const Kinds& kinds,
                                     const Posterior& same) {
  std::vector<Candidate> candidates;
  for (const Model* model : posterior.model().siblings()) {
    if (!model->kind().is_central) continue;
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

Eigen::MatrixXd projection_of(const Posterior& posterior, double distance_m) {
  return aligned_jacobian(
      {&posterior.model(), {posterior.fit.bundle.lens(), posterior.fit.bundle.image_size}, {}},
      seen_region(posterior.fit.bundle).samples(), distance_m);
}

bool agrees(const Component& component, const Mean& mean, const Eigen::MatrixXd& projection) {
  const Index k = projection.cols();
  const VectorXd d = projection * (component.values - mean.values).head(k);
  for (Index row = 0; row + 1 < projection.rows(); row += 2) {
    const auto rows = projection.middleRows<2>(row);
    const double variance = (rows * mean.covariance.topLeftCorner(k, k)).cwiseProduct(rows).sum();
    if (!(d.segment<2>(row).norm() <= policy::kAgreeingSigmas * std::sqrt(variance))) return false;
  }
  return true;
}

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

}  // namespace tagcal::internal
