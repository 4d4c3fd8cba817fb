#include "tagcal/detect/board_search/placed_tag.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "tagcal/detect/policy/policy.hpp"
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

std::vector<const PlacedTag*> nearest_tags(const PlacedTag& tag,
                                           const std::vector<const PlacedTag*>& seen) {
  std::vector<std::pair<double, const PlacedTag*>> order;
  for (const PlacedTag* other : seen)
    if (other != &tag) order.emplace_back((other->centre - tag.centre).squaredNorm(), other);
  const std::size_t count = std::min(order.size(), policy::kBoardNeighbours);
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count));
  std::vector<const PlacedTag*> nearest;
  for (std::size_t i = 0; i < count; ++i) nearest.push_back(order[i].second);
  return nearest;
}

std::vector<PlacedTag*> nearest_first(std::vector<std::pair<double, PlacedTag*>> by_distance) {
  std::ranges::stable_sort(by_distance, {}, &std::pair<double, PlacedTag*>::first);
  std::vector<PlacedTag*> result;
  for (const auto& [distance, tag] : by_distance) result.push_back(tag);
  return result;
}

std::optional<PlaneView> PlaneView::about(const PlacedTag& tag,
                                          const std::vector<const PlacedTag*>& from,
                                          std::size_t count, const Lens* lens) {
  PlaneView view;
  view.lens_ = lens;
  view.origin_ = tag.centre;
  view.scale_ = 1 / (tag.corners[1] - tag.corners[0]).norm();
  view.middle_ = centre_of(*from.front()->seen);
  view.per_px_ = 1 / shortest_side(*from.front()->seen);
  std::vector<Vector2d> points;
  std::vector<Vector3d> rays;
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t i = 0; i < 4; ++i) {
      points.emplace_back(view.scale_ * (from[n]->corners[i] - tag.centre));
      rays.push_back(view.ray((*from[n]->seen)[i]));
      if (rays.back().isZero(0)) return std::nullopt;
    }
  }
  const auto h = homography(points, rays);
  if (!h) return std::nullopt;
  view.rays_from_plane_ = *h;
  return view;
}

// Zero outside the lens' domain.
Vector3d PlaneView::ray(const Vector2d& pixel) const {
  if (!lens_) return (per_px_ * (pixel - middle_)).homogeneous();
  const auto ray = ray_in_camera(*lens_, pixel);
  return ray ? ray->direction : Vector3d::Zero();
}

std::optional<Vector2d> PlaneView::pixel(const Vector2d& on_panel) const {
  const Vector3d ray = rays_from_plane_ * Vector2d(scale_ * (on_panel - origin_)).homogeneous();
  if (lens_) return project(*lens_, ray);
  if (!(ray.z() > 0)) return std::nullopt;
  return ray.hnormalized() / per_px_ + middle_;
}

std::optional<Vector2d> PlaneView::on_plane(const Vector2d& pixel) const {
  const Vector3d at = rays_from_plane_.inverse() * ray(pixel);
  if (!(at.z() > 0)) return std::nullopt;
  return at.hnormalized() / scale_ + origin_;
}

std::optional<Quad> predicted(const PlacedTag& tag, const std::vector<const PlacedTag*>& from,
                              std::size_t count, const Lens* lens) {
  const auto view = PlaneView::about(tag, from, count, lens);
  if (!view) return std::nullopt;
  const auto quad = mapped(tag.corners, [&](const Vector2d& x) { return view->pixel(x); });
  return quad && is_face(*quad) ? quad : std::nullopt;
}

}  // namespace tagcal::internal
