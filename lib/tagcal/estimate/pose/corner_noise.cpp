#include "tagcal/estimate/pose/corner_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {

void CornerNoise::add(const View& view) {
  num_corners += view.observations.size();
  num_known += static_cast<std::size_t>(std::ranges::count_if(
      view.observations, [](const Observation& o) { return o.covariance_px2.has_value(); }));
}

Matrix2 covariance_or_assumed(const Observation& corner) {
  return corner.covariance_px2.value_or(policy::kAssumedSigmaPx * policy::kAssumedSigmaPx *
                                        Matrix2::Identity());
}

double sigma_of_residuals(double square_px2, std::size_t num_corners, std::size_t num_views,
                          std::vector<Finding>& findings) {
  const double freedom = 2 * static_cast<double>(num_corners) - 6 * static_cast<double>(num_views);
  if (freedom >= policy::kEnoughDegreesOfFreedom)
    return std::max(kLeastNoisePx, std::sqrt(square_px2 / freedom));
  add(findings, code::noise_assumed,
      fmt::format("the corners are too few to estimate their noise: {} px is assumed",
                  policy::kAssumedSigmaPx));
  return policy::kAssumedSigmaPx;
}

}  // namespace tagcal::internal
