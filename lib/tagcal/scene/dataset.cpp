#include "tagcal/scene/dataset.hpp"

namespace tagcal {

std::map<CornerId, Eigen::Vector3d> points_in_world(const std::vector<PlacedBoard>& boards) {
  std::map<CornerId, Eigen::Vector3d> points;
  for (const PlacedBoard& placed : boards)
    for (const TargetPoint& point : target_points(placed.board))
      points.emplace(point.id, placed.world_from_board * point.position);
  return points;
}

}  // namespace tagcal
