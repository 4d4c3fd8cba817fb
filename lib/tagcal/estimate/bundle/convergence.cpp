#include "tagcal/estimate/bundle/convergence.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMaxRounds = 10;

// Standard deviation of the projected corners for known poses, sigma sqrt(k / n), RMS; sigma from
// the residuals in pixels (whitened ones have no unit).
double corner_sigma_px(const Bundle& bundle) {
  const Lens lens = bundle.lens();
  double sum = 0;
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const auto& r :
         residuals_px(bundle.views[v].correspondences, lens, bundle.camera_from_target[v]))
      sum += r.squaredNorm();
  const double n = 2.0 * num_corners(bundle);
  return std::sqrt(sum / std::max(1, degrees_of_freedom(bundle)) * bundle.model->num_free() / n);
}

double sigma_of(const Bundle& bundle, const BundleSummary& summary) {
  return std::max(policy::kLeastSigmaPx,
                  std::sqrt(summary.cost / std::max(1, degrees_of_freedom(bundle))));
}

}  // namespace

PixelDisplacement pixel_displacement(const Bundle& a, const Bundle& b) {
  const Lens lens_a = a.lens(), lens_b = b.lens();
  PixelDisplacement result;
  int count = 0;
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    const auto in_a = residuals_px(a.views[v].correspondences, lens_a, a.camera_from_target[v]);
    const auto in_b = residuals_px(b.views[v].correspondences, lens_b, b.camera_from_target[v]);
    for (std::size_t i = 0; i < in_a.size(); ++i, ++count) {
      const double d = (in_a[i] - in_b[i]).norm();
      result.rms_px += d * d;
      result.max_px = std::max(result.max_px, d);
    }
  }
  result.rms_px = std::sqrt(result.rms_px / std::max(count, 1));
  return result;
}

void continue_until_converged(Bundle& bundle, BundleSummary& summary, int max_iterations) {
  for (int round = 0; round < kMaxRounds && !summary.converged; ++round) {
    if (observability(bundle, sigma_of(bundle, summary)).status != Status::ok) return;
    const Bundle before = bundle;
    const BundleSummary more = solve(bundle, max_iterations);
    summary.num_iterations += more.num_iterations;
    summary.cost = more.cost;
    summary.converged = more.converged || pixel_displacement(before, bundle).rms_px <
                                              policy::kStationaryShare * corner_sigma_px(bundle);
  }
}

bool stuck_at_domain_limit(const Bundle& bundle, const BundleSummary& summary) {
  return observability(bundle, sigma_of(bundle, summary)).decrement > policy::kLargestDecrement;
}

}  // namespace tagcal::internal
