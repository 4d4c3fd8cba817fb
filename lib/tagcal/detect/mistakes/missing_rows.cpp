#include "tagcal/detect/mistakes/missing_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

using Places = std::map<CornerId, Vector2d>;

Places places_on(const Board& board) {
  Places places;
  for (const TargetPoint& point : target_points(board))
    places.emplace(point.id, point.position.head<2>());
  return places;
}

int row_of(const AprilGrid& grid, const CornerId& id) {
  return (id.tag_id - grid.first_id) / grid.columns;
}

// The picture shows much of the board, and its homography puts much of this row, and half of the
// distance to it again, inside of the picture.
bool has_room(const DetectedPicture& picture, const Places& places, const AprilGrid& grid,
              int row) {
  std::vector<Vector2d> points;
  std::vector<Eigen::Vector3d> rays;
  const Vector2d middle = image_centre(picture.size);
  const double scale = picture.size.width;
  for (const Observation& seen : picture.view.observations)
    if (const auto place = places.find(seen.id); place != places.end()) {
      points.push_back(place->second);
      rays.push_back(((seen.pixel - middle) / scale).homogeneous());
    }
  if (points.size() < 4) return false;
  double before = 0, of_row = 0, inside = 0;
  const auto pixels = homography(points, rays);
  for (const auto& [id, place] : places) {
    before += row_of(grid, id) < row;
    if (!pixels || row_of(grid, id) != row) continue;
    const Vector2d below = places.at({id.tag_id - grid.columns, id.corner});
    const Vector2d beyond = place + (place - below) / 2;  // half a row farther
    const Eigen::Vector3d ray = *pixels * beyond.homogeneous();
    ++of_row;
    inside += ray.z() > 0 && contains(picture.size, scale * ray.hnormalized() + middle);
  }
  return static_cast<double>(points.size()) >= policy::kShownShare * before && of_row > 0 &&
         inside >= policy::kShownShare * of_row;
}

}  // namespace

std::optional<TargetMistake> missing_rows(const std::vector<DetectedPicture>& found,
                                          const Board& board) {
  const auto* const grid = std::get_if<AprilGrid>(&board.pattern);
  if (!grid) return std::nullopt;
  const Places places = places_on(board);
  int seen = 0;  // rows
  for (const DetectedPicture& picture : found)
    for (const Observation& corner : picture.view.observations)
      if (places.contains(corner.id)) seen = std::max(seen, row_of(*grid, corner.id) + 1);
  if (seen == 0 || seen == grid->rows) return std::nullopt;
  const auto with_room = std::ranges::count_if(found, [&](const DetectedPicture& picture) {
    return has_room(picture, places, *grid, seen);
  });
  if (with_room < policy::kPicturesWithRoom) return std::nullopt;
  return TargetMistake{
      "wrong rows",
      fmt::format("no picture shows more than {} of the {} rows of tags, although {} have room for "
                  "the next one; if the board has no more, write tagRows: {}",
                  seen, grid->rows, with_room, seen)};
}

}  // namespace tagcal::internal
