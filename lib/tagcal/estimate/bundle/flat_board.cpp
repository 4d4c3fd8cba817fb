#include "tagcal/estimate/bundle/flat_board.hpp"

#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

// A prior's standard deviation: as stated, or of the material.
double share_of(const Tolerance& tolerance, std::span<const double> of_materials) {
  if (const double* const stated = std::get_if<double>(&tolerance)) return *stated;
  return of_materials[static_cast<std::size_t>(std::get<Material>(tolerance))];
}

}  // namespace

double sigma_of_print(const Tolerance& print) { return share_of(print, policy::kPriorPrint); }

double sigma_of_scale(double sigma_of_print, double found_aspect) {
  return std::hypot(sigma_of_print, found_aspect) / std::sqrt(2.0);
}

BoardShapes FlatBoard::shapes(std::span<const Eigen::Vector3d> x_in_world) const {
  const Pose board_from_world = world_from_board.inverse();
  const Eigen::Matrix<double, 2, 3> axes =
      board_from_world.rotation().toRotationMatrix().topRows<2>();
  const Eigen::Vector2d origin = board_from_world.translation().head<2>() - centre;
  const Eigen::Vector2d per_metre = half_size.cwiseInverse();
  const Eigen::Quaterniond& turn = world_from_board.rotation();
  BoardShapes result{{}, turn * Eigen::Vector3d::UnitZ(), turn * Eigen::Vector3d::UnitY()};
  result.of_points.reserve(x_in_world.size());
  for (const Eigen::Vector3d& x : x_in_world) {
    const Eigen::Vector2d in_board = axes * x + origin;
    const Eigen::Vector2d at = in_board.cwiseProduct(per_metre);
    result.of_points.emplace_back(1 - at.x() * at.x(), 1 - at.y() * at.y(), at.x() * at.y(),
                                  in_board.y());
  }
  return result;
}

std::optional<FlatBoard> flat_board(const Dataset& dataset) {
  if (dataset.boards.size() != 1) return std::nullopt;
  const Substrate& substrate = dataset.boards[0].board.substrate;
  check_substrate(substrate);
  const auto points = target_points(dataset.boards[0].board);
  if (points.empty()) return std::nullopt;
  Eigen::Vector3d low = points[0].position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  const Eigen::Vector3d size = high - low;
  const double rounding_m = 1e-6 * size.x();  // numeric: of positions in a file
  if (!(size.x() > 0 && size.y() > 0) || size.z() > rounding_m) return std::nullopt;
  const double bend_m = share_of(substrate.flatness, policy::kPriorFlatness) * size.norm();
  const double print = sigma_of_print(substrate.print);
  return FlatBoard{dataset.boards[0].world_from_board,
                   (low + high).head<2>() / 2,
                   size.head<2>() / 2,
                   {bend_m, bend_m, bend_m, print},
                   substrate};
}

}  // namespace tagcal::internal
