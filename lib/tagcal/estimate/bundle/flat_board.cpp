#include "tagcal/estimate/bundle/flat_board.hpp"

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d FlatBoard::shape(const Vector3d& x_in_board) const {
  const Vector2d unit = (x_in_board.head<2>() - centre).cwiseQuotient(half_size);
  return Vector2d::Ones() - unit.cwiseAbs2();
}

std::vector<Vector2d> FlatBoard::shapes(std::span<const Vector3d> x_in_world) const {
  const Pose board_from_world = world_from_board.inverse();
  std::vector<Vector2d> result;
  result.reserve(x_in_world.size());
  for (const Vector3d& x : x_in_world) result.push_back(shape(board_from_world * x));
  return result;
}

Vector3d FlatBoard::normal_in_world() const {
  return world_from_board.rotation() * Vector3d::UnitZ();
}

std::optional<FlatBoard> flat_board(const Dataset& dataset) {
  if (dataset.boards.size() != 1) return std::nullopt;
  const auto points = target_points(dataset.boards[0].board);
  if (points.empty()) return std::nullopt;
  Vector3d low = points[0].position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  const Vector3d size = high - low;
  if (!(size.x() > 0 && size.y() > 0) || size.z() > policy::kFlatBoard * size.x())
    return std::nullopt;
  return FlatBoard{dataset.boards[0].world_from_board, (low + high).head<2>() / 2,
                   size.head<2>() / 2};
}

}  // namespace tagcal::internal
