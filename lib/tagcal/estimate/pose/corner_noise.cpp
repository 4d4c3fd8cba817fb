#include "tagcal/estimate/pose/corner_noise.hpp"

#include <algorithm>

#include "tagcal/estimate/policy/policy.hpp"

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

}  // namespace tagcal::internal
