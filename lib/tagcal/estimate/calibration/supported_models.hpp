#pragma once

#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/calibration/model_ladder.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"

namespace tagcal::internal {

// Of the image's diagonal: cameras have their principal points some per cent beside the centre.
inline constexpr double kCentreSpread = 0.02;

// Models of a smaller weight count, and are not named: sentences say whole per cents.
inline constexpr double kWorthAWord = 0.005;

// A model that the data support beside the chosen one, and by how much.
struct SupportedModel {
  Bundle bundle;
  std::vector<std::size_t> views;  // of the data set, by number, per view of the bundle
  BundleCovariance covariance;
  double weight = 0;  // Akaike's, among the chosen model and all of these
};

// The models of the ladder that the data determine and that the chosen one does not contain (those
// that are not determined, stopped at a fold or have a pole: to first order about the largest one
// below, with the principal point within kCentreSpread where it is not determined), with
// Akaike weights w ~ exp(-AIC / 2), AIC = chi-square + 2 k (Burnham & Anderson, Model Selection and
// Multimodel Inference, 2002, section 2.9). BIC chooses the model; how much the choice leaves out
// is a question of prediction, which is AIC's. Weights below 1e-4 are left out: such a model is
// wrong more surely than the mark of one wrong claim in 1,000 asks. `inflation`: of the
// chi-squares, where residuals are not independent (ResidualField::inflation; QAIC, ibid.
// section 2.5).
std::vector<SupportedModel> supported_models(const Ladder& ladder, const Rung& chosen,
                                             double inflation);

// The unconditional covariance of an estimate that was made with one of several supported models:
// sum of w_i (C_i + d_i d_i'), d_i the difference to the estimate (Burnham & Anderson, eq. 4.9, as
// a variance). Coefficients that mean another thing in the other model keep the chosen one's
// variance; poses count where the models have the same views.
void add_model_uncertainty(BundleCovariance& covariance, const Bundle& chosen,
                           std::span<const std::size_t> views,
                           std::span<const SupportedModel> others);

// The same of the projection over the image, the pose between the lenses taken out. A node at which
// a supported lens has no ray, or does not see the point, has no value.
void add_model_uncertainty(ProjectionUncertainty& projection, const Camera& chosen,
                           std::span<const SupportedModel> others,
                           std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal::internal
