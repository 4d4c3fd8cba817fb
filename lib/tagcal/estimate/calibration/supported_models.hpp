#pragma once

#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/model_ladder.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {

// A model that the data support beside the chosen one.
struct SupportedModel {
  Bundle bundle;
  std::vector<std::size_t> views;  // per view of the bundle: its index in the data set
  BundleCovariance covariance;
  double weight = 0;  // Akaike weight among the chosen model and all of these
};

// The candidates that the chosen model does not contain, with Akaike weights w ~ exp(-AIC / 2),
// AIC = chi-square + 2 k (Burnham & Anderson, Model Selection and Multimodel Inference, 2002,
// section 2.9): BIC chooses the model, AIC measures the loss of prediction by the choice.
// Candidates that are not usable (not determined, stopped at a fold, a pole) or whose coefficients
// the data do not locate count to first order about the largest located one that they contain, with
// the principal point within policy::kCentreSpread if it is not determined. Drops weights below
// policy::kLeastModelWeight. `inflation`: divides the chi-squares if residuals are not independent
// (ResidualBias::inflation; QAIC, ibid. section 2.5).
std::vector<SupportedModel> supported_models(const ModelLadder& ladder, const Candidate& chosen,
                                             double inflation);

// Makes the covariance of an estimate unconditional on the chosen model: sum of w_i (C_i + d_i
// d_i'), d_i the difference to the estimate (Burnham & Anderson, eq. 4.9, as a variance).
// Coefficients with another meaning in the other model keep the chosen one's variance; poses change
// only if the models have the same views.
void add_model_uncertainty(BundleCovariance& covariance, const Bundle& chosen,
                           std::span<const std::size_t> views,
                           std::span<const SupportedModel> others);

// The same for the projection over the image, after the best relative pose of the two lenses. A
// node has no value if a supported lens has no ray there or does not see the point.
void add_model_uncertainty(ProjectionUncertainty& projection, const Camera& chosen,
                           std::span<const SupportedModel> others,
                           std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal::internal
