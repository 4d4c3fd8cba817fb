#include "tagcal/estimate/view_correspondences.hpp"

#include <fmt/format.h>

#include <array>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"

namespace tagcal {
using namespace internal;

ViewCorrespondences view_correspondences(const View& view,
                                         const std::map<CornerId, Eigen::Vector3d>& target,
                                         const std::optional<double>& camera_error_px) {
  ViewCorrespondences result;
  CornerNoise noise;
  noise.add(view);
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    const Observation& seen = view.observations[i];
    const auto point = target.find(seen.id);
    if (point == target.end()) continue;
    result.ids.push_back(seen.id);
    result.observations.push_back(i);
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

Dataset dataset_from_correspondences(std::span<const std::vector<Correspondence>> views,
                                     const ImageSize& image_size) {
  Points board;
  std::map<std::array<double, 3>, CornerId> ids;
  Dataset dataset{image_size, {}, {}, {}};
  for (std::size_t v = 0; v < views.size(); ++v) {
    View& view = dataset.views.emplace_back();
    std::set<CornerId> seen;
    for (const auto& [point, pixel] : views[v]) {
      if (!point.allFinite() || !pixel.allFinite())
        throw Error(fmt::format("view {}: points and pixels must be finite", v));
      const CornerId next{static_cast<int>(board.points.size()), 0};
      const auto [place, is_new] = ids.emplace(std::array{point.x(), point.y(), point.z()}, next);
      if (is_new) board.points.push_back({next, point});
      if (!seen.insert(place->second).second)
        throw Error(fmt::format("view {}: the point ({:g}, {:g}, {:g}) occurs twice", v, point.x(),
                                point.y(), point.z()));
      view.observations.push_back({place->second, pixel, std::nullopt});
    }
  }
  dataset.boards.push_back({{std::move(board), {}}, Pose()});
  return dataset;
}

}  // namespace tagcal
