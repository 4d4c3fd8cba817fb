#include "tagcal/estimate/pose/view_correspondences.hpp"

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

ViewCorrespondences view_correspondences(const View& view,
                                         const std::map<CornerId, Eigen::Vector3d>& target,
                                         const std::optional<double>& camera_error_px) {
  ViewCorrespondences result;
  CornerNoise noise;
  noise.add(view);
  for (const Observation& seen : view.observations) {
    const auto point = target.find(seen.id);
    if (point == target.end()) continue;
    result.ids.push_back(seen.id);
    result.correspondences.push_back({point->second, seen.pixel});
    result.groups.push_back(seen.id.tag_id);
    if (!camera_error_px || !noise.counts()) continue;
    const Matrix2 own = covariance_or_assumed(seen);
    result.covariance_px2.emplace_back(own +
                                       *camera_error_px * *camera_error_px * Matrix2::Identity());
  }
  return result;
}

}  // namespace tagcal::internal
