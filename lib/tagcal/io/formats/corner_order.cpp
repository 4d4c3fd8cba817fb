#include "tagcal/io/formats/corner_lists.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"

namespace tagcal::internal {

std::vector<CornerId> listed_corners(const std::vector<PlacedBoard>& boards,
                                     const std::string& where) {
  if (boards.size() != 1)
    throw Error(fmt::format("{}: a list of corners needs a data set of one board, not {}", where,
                            boards.size()));
  const Board& board = boards[0].board;
  std::vector<CornerId> corners;
  if (const auto grid = point_grid(board)) {
    for (int row = grid->rows - 1; row >= 0; --row)
      for (int column = 0; column < grid->columns; ++column)
        corners.push_back({grid->first_id + row * grid->columns + column, 0});
    return corners;
  }
  if (point_kind(board) == PointKind::tag_corner)
    throw Error(where +
                ": a list of corners in order needs a target of type checkerboard, charuco, "
                "circlegrid or points: the corners of tags are no regular grid");
  for (const TargetPoint& point : target_points(board)) corners.push_back(point.id);
  return corners;
}

std::string view_name(std::size_t index) { return fmt::format("view{:04}", index); }

}  // namespace tagcal::internal
