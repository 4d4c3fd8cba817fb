#include "tagcal/estimate/bundle/flat_board.hpp"

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {

using Eigen::Vector2d;
using Eigen::Vector3d;

BoardShapes FlatBoard::shapes(std::span<const Vector3d> x_in_world) const {
  const Pose board_from_world = world_from_board.inverse();
  BoardShapes result{{}, world_from_board.rotation() * Vector3d::UnitZ()};
  result.of_points.reserve(x_in_world.size());
  for (const Vector3d& x : x_in_world) {
    const Vector2d in_board = (board_from_world * x).head<2>() - centre;
    result.of_points.push_back(Vector2d::Ones() - in_board.cwiseQuotient(half_size).cwiseAbs2());
  }
  return result;
}

void FlatBoard::bend(ViewProblem& view, const Vector2d& by_m) const {
  const BoardShapes bends = shapes(ViewArrays(view).view().points);
  for (std::size_t i = 0; i < view.correspondences.size(); ++i)
    view.correspondences[i].point += bends.of_points[i].dot(by_m) * bends.normal;
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
