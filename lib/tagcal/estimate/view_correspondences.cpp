#include "tagcal/estimate/view_correspondences.hpp"

#include "tagcal/estimate/pose/corner_noise.hpp"

namespace tagcal {
using namespace internal;

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

ViewCorrespondences view_correspondences(const View& view, const std::vector<PlacedBoard>& boards,
                                         const std::optional<double>& camera_error_px) {
  return view_correspondences(view, points_in_world(boards), camera_error_px);
}

std::vector<Correspondence> correspondences(const View& view,
                                            const std::vector<PlacedBoard>& boards) {
  return view_correspondences(view, boards).correspondences;
}

}  // namespace tagcal
