#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/calibration/kinds.hpp"

namespace tagcal::internal {

// A candidate for the answer: a component of the posterior, or another kind of lens.
struct Candidate {
  Component component;
  double bic = 0;
  bool is_nested = false;  // in the posterior's model: it can be the answer
};

// The components of a posterior: the models nested in it, and the other kinds. `same`: the
// posterior of its model among the kinds.
std::vector<Candidate> candidates_of(const Posterior& posterior, const Kinds& kinds,
                                     const Posterior& same);

// Weights of the components: exp(-(chi-square - occam) / 2).
void set_weights(std::vector<Candidate>& candidates);

// The lens of a component; no value outside of the domain of its model.
std::optional<Lens> lens_of(const Component& component, const Posterior& posterior);

// The Jacobian of the projection over the region of the corners, by the posterior's lens.
Eigen::MatrixXd projection_of(const Posterior& posterior, double distance_m);

// The claim of the components about their mean.
struct Mean {
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
};

std::vector<Component> components_of(const std::vector<Candidate>& candidates);
Mean mean_of(const std::vector<Candidate>& candidates);

// The projections of a component and of the mean differ by at most policy::kAgreeingSigmas of the
// claim over the region of the corners.
bool agrees(const Component& component, const Mean& mean, const Eigen::MatrixXd& projection);

}  // namespace tagcal::internal
