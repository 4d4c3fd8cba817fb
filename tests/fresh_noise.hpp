#pragma once

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"
#include "worlds.hpp"

// Projection uncertainty as predicted at the truth, and as solves with fresh noise show it.

namespace tagcal {
using namespace internal;

// A world as a solved problem: exact pixels, the true lens and poses.
inline Bundle exact_bundle(const Model& model, const Lens& lens, std::uint64_t seed,
                           WorldOptions options) {
  options.sigma_px = 0;
  const Dataset world = make_world(lens, seed, options);
  const auto points = points_in_world(world.boards);
  Bundle bundle;
  bundle.model = &model;
  bundle.image_size = world.image_size;
  bundle.free_values = model.free_values(lens);
  for (const View& view : world.views) {
    ViewProblem problem;
    for (const Observation& o : view.observations)
      problem.correspondences.push_back({points.at(o.id), o.pixel});
    bundle.views.push_back(problem);
    bundle.camera_from_target.push_back(world.truth->camera_from_world.at(view.image));
  }
  return bundle;
}

// The covariance of the lens for independent noise, the bundle's priors included.
inline Eigen::MatrixXd covariance_for(const Bundle& exact, double sigma_px) {
  const Eigen::Index k = exact.model->num_free();
  return exact_inverse(bundle_information(exact)->total(sigma_px))->topLeftCorner(k, k);
}

inline Bundle with_noise(Bundle bundle, double sigma_px, Random random) {
  for (ViewProblem& view : bundle.views)
    for (Correspondence& c : view.correspondences.own())
      c.pixel += sigma_px * Eigen::Vector2d(random.normal(), random.normal());
  return bundle;
}

struct PredictedAndObserved {
  ProjectionUncertainty predicted;
  Eigen::MatrixXd variance;  // observed, per coordinate, at the nodes
  int solves = 0;

  double ratio(int row, int column) const {  // of standard deviations, observed / predicted
    return std::sqrt(variance(row, column)) / predicted.sigma_px(row, column);
  }
};

inline PredictedAndObserved fresh_noise(const Bundle& exact, double sigma_px, double distance_m,
                                        int solves) {
  const std::vector<Eigen::Vector2d> samples = seen_region(exact).samples();
  PredictedAndObserved result;
  result.predicted = projection_uncertainty(
      {exact.model, {exact.lens(), exact.image_size}, covariance_for(exact, sigma_px)},
      {exact.image_size}, samples, distance_m);
  result.variance = 0 * result.predicted.sigma_px;
  for (int i = 0; i < solves; ++i) {
    Bundle noisy = with_noise(exact, sigma_px, Random(77, static_cast<std::uint64_t>(i)));
    noisy.sigma = sigma_px;
    if (!solve(noisy, 50).converged) continue;
    const auto d = lens_difference({exact.lens(), exact.image_size},
                                   {noisy.lens(), exact.image_size}, samples, distance_m);
    if (!d) continue;
    result.variance += 0.5 * (d->u_px.array().square() + d->v_px.array().square()).matrix();
    ++result.solves;
  }
  result.variance /= std::max(1, result.solves);
  return result;
}

}  // namespace tagcal
