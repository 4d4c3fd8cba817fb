#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/posterior.hpp"

namespace tagcal::internal {

// The answer of a calibration, and what the data and the priors say about it.
struct ModelChoice {
  CalibrationFit fit;   // of the answer's model
  Posterior posterior;  // that carries the claim: of the largest model that the data need
  // The covariance about the answer, by the posterior's parameters: the claim.
  BundleCovariance claim;
  std::vector<ModelStep> steps;  // empty for a model that was asked for by name
  // The share of chi-square that another kind of lens explains beyond the one asked for; 0: none.
  double other_lens_share = 0;

  const Model& claim_model() const { return posterior.model(); }
};

// Fits the model that the options name: it is the posterior as well. No value if no view has a
// consensus, or a view does not determine its pose.
std::optional<ModelChoice> fit_named(const CalibrationInput& input,
                                     const CalibrateOptions& options);

// Chooses the model (`auto`).
//   1. Fits the largest perspective and the fisheye robustly, each with its priors, to at most
//      policy::kChoiceViews views, evenly spread. The posterior is that of the better kind; of a
//      polynomial instead of a rational lens where that explains the corners as well.
//   2. The posterior of all views has a component for each nested model (nested_in) and each other
//      kind (as_seen_by), with weights exp(-(chi-square + penalty) / 2). The claim is their
//      mixture.
//   3. The answer is the nested model of the lowest BIC, whose projection is within the claim's
//      standard deviation of the posterior's mean wherever corners are; or, with a tolerance, the
//      smallest one within it. It is refitted on the posterior's inliers.
std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options);

}  // namespace tagcal::internal
