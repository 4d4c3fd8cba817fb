#include "tagcal/detect/board_search/placed_tag.hpp"

#include <Eigen/Geometry>

#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {

using Eigen::Vector2d;
using Eigen::Vector3d;

Quad on_panel(const Tag& tag, const Pose& panel_from_board) {
  Quad result;
  const auto corners = tag_corners(tag);
  for (std::size_t i = 0; i < 4; ++i) result[i] = (panel_from_board * corners[i]).head<2>();
  return result;
}

std::optional<Quad> predicted(const PlacedTag& tag, const std::vector<const PlacedTag*>& from,
                              std::size_t count) {
  const double scale = 1 / (tag.corners[1] - tag.corners[0]).norm();
  const Vector2d middle = centre_of(*from.front()->seen);
  const double pixel = 1 / shortest_side(*from.front()->seen);
  std::vector<Vector2d> points;
  std::vector<Vector3d> rays;
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t i = 0; i < 4; ++i) {
      points.emplace_back(scale * (from[n]->corners[i] - tag.centre));
      rays.emplace_back((pixel * ((*from[n]->seen)[i] - middle)).homogeneous());
    }
  }
  const auto h = homography(points, rays);
  if (!h) return std::nullopt;
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d ray = *h * Vector2d(scale * (tag.corners[i] - tag.centre)).homogeneous();
    if (!(ray.z() > 0)) return std::nullopt;  // beyond the horizon
    quad[i] = ray.hnormalized() / pixel + middle;
  }
  if (!is_face(quad)) return std::nullopt;
  return quad;
}

}  // namespace tagcal::internal
