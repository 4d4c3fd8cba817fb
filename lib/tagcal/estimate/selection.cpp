#include "tagcal/estimate/selection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sub-models of opencv5, square pixels not assumed.
const std::vector<Model>& lean_models() {
  static const std::vector<FreeParameter> all = {{"fx", {0}}, {"fy", {1}}, {"cx", {2}},
                                                 {"cy", {3}}, {"k1", {4}}, {"k2", {5}},
                                                 {"p1", {6}}, {"p2", {7}}};
  static const auto first = [](std::ptrdiff_t n) {
    return Model("lean", LensType::perspective, {all.begin(), all.begin() + n});
  };
  static const std::vector<Model> models = {first(4), first(5), first(6), first(8)};
  return models;
}

double counted(double square, double sigma_square) {
  return std::min(square / sigma_square, kRejectSigmas * kRejectSigmas);
}

// The squared residuals of a bundle's corners, each counted up to the rejection bound.
double counted_misfit(const Bundle& bundle, double sigma_square) {
  double sum = 0;
  const Lens lens = bundle.lens();
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const ViewProblem& view = bundle.views[v];
    const auto residuals = residuals_px(view.correspondences, lens, bundle.camera_from_target[v]);
    for (std::size_t i = 0; i < residuals.size(); ++i)
      sum += counted(whitened_square(view, i, residuals[i]), sigma_square);
  }
  return sum;
}

// The lowest BIC of the sub-models of a solved perspective, on its inliers. `bic` must be set.
double leanest_bic(const CalibrationFit& fit, double sigma_square) {
  if (fit.bundle.model->lens_type() != LensType::perspective) return kInfinity;
  double lowest = kInfinity;
  for (const Model& model : lean_models()) {
    Bundle bundle = fit.bundle;
    bundle.model = &model;
    bundle.free_values = model.free_values(fit.bundle.lens());
    const BundleSummary summary = solve(bundle, 50);
    if (!summary.converged) continue;
    const int fewer = fit.bundle.model->num_free() - model.num_free();
    const double worse =
        counted_misfit(bundle, sigma_square) - counted_misfit(fit.bundle, sigma_square);
    lowest = std::min(lowest, fit.bic + worse - fewer * std::log(2.0 * fit.num_corners));
  }
  return lowest;
}

}  // namespace

std::size_t choose_fit(std::vector<CalibrationFit>& fits) {
  double sigma_square = kInfinity;
  for (const CalibrationFit& fit : fits)
    if (2 * fit.num_inliers() >= fit.num_corners && fit.num_inliers() > 0)
      sigma_square = std::min(sigma_square, fit.summary.cost / (2.0 * fit.num_inliers()));
  if (!std::isfinite(sigma_square)) sigma_square = 1;
  sigma_square = std::max(sigma_square, 1e-12);
  std::size_t best = 0;
  for (std::size_t f = 0; f < fits.size(); ++f) {
    CalibrationFit& fit = fits[f];
    fit.bic = fit.bundle.model->num_free() * std::log(2.0 * fit.num_corners);
    for (const double square : fit.squares) fit.bic += counted(square, sigma_square);
    if (fits.size() > 1) fit.bic = std::min(fit.bic, leanest_bic(fit, sigma_square));
    if (fit.bic < fits[best].bic) best = f;
  }
  return best;
}

}  // namespace tagcal
