#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Noise per (whitened) coordinate: as stated, that of the corners, that of the residuals, or
// policy::kAssumedSigmaPx.
struct BundleNoise {
  double sigma = 0;
  bool from_residuals = false;
};
BundleNoise noise_of(const CalibrationFit& fit, const CalibrateOptions& options);

// The overdispersion that the correlations of residuals suggest, before poses are compared:
// policy::kLeastOverdispersion, more for positive correlations of neighbouring corners, times what
// views of one pose share (design_effect).
double expected_overdispersion(const Bundle& solved, std::span<const std::size_t> pose_of_view);

// A solved fit of a model, with its information and covariance by views.
struct Posterior {
  CalibrationFit fit;
  BundleNoise noise;
  BundleInformation information;
  BundleCovariance covariance;

  const Model& model() const { return *fit.bundle.model; }
  Eigen::VectorXd values() const;  // free parameters, then the shapes of the board
};

// No value if a view does not determine its pose.
std::optional<Posterior> posterior_of(CalibrationFit fit, const CalibrateOptions& options);

// An estimate of a lens and its board, in the parameters of another posterior: `values` and
// `covariance` by those of a Posterior.
struct Component {
  const Model* model = nullptr;
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  double chi_square = 0;  // above that of the posterior, over its overdispersion
  // Twice the logarithm of the prior odds of what the model holds, for each held parameter at most
  // policy::kComponentPenalty: the volume of the prior over that of the posterior (Savage-Dickey).
  double occam = 0;
  double weight = 0;
};

// Predicts the fit of a model nested in the posterior's, from the posterior alone. The model
// restricts the parameters to x = P y + c: with H the information and V the covariance,
//   y = (P'HP)^-1 P'H (x - c),  covariance M V M' with M = P (P'HP)^-1 P'H,
// chi-square = e'H e / phi with e = x - c - P y. No value if the model is not nested.
std::optional<Component> nested_in(const Posterior& posterior, const Model& model);

// The lens and covariance of another posterior by the parameters of `to`: those that reproduce its
// projection best over the image, the turn of the camera taken out: least squares in units of the
// standard deviations that `to` claims there, and with its priors. No value if the lenses have too
// few rays in common.
std::optional<Component> as_seen_by(const Posterior& other, const Posterior& to);

// The same logarithm for all parameters of a posterior: what it pays for being free.
double occam(const Posterior& posterior);

// The increase of an answer's covariance by the curvature of the likelihood, by the posterior's
// parameters (profile_covariance). `covariance`: of the answer, by the same.
Eigen::MatrixXd curvature_of(const CalibrationFit& answer, const Eigen::MatrixXd& covariance,
                             const Posterior& posterior);

// The covariance of all components about an answer: sum of weight (C + d d'), d = values - answer.
Eigen::MatrixXd mixture_about(const Eigen::VectorXd& answer, std::span<const Component> components);

}  // namespace tagcal::internal
