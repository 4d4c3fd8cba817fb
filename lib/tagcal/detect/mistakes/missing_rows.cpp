#include "tagcal/detect/mistakes/mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tagcal/camera/camera.hpp"
#include "tagcal/detect/board_search/tag_count.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// numeric: rows, larger than rounding. A ChArUco board's corners lie exactly between two rows.
constexpr double kRowRounding = 1e-6;

// The rows of a board's tags or markers, in the order of their ids. If the target file says too
// many, the last ones are missing.
struct TagRows {
  std::vector<Tag> tags;
  double step = 0;  // from a row to the next, along y, metres
  int count = 0;
  const char* key = "";  // of the target file
  const char* parts = "";
  std::map<CornerId, Vector2d> points = {};  // of the target

  double row_at(double y) const {
    return (y - tags.front().board_from_tag.translation().y()) / step;
  }
  int row_of(const Tag& tag) const {
    return static_cast<int>(std::lround(row_at(tag.board_from_tag.translation().y())));
  }
  bool is_before(const Vector2d& point, int row) const {
    return row_at(point.y()) < row - 1.0 / 2 - kRowRounding;
  }
};

std::optional<TagRows> rows_of(const Board& board) {
  TagRows rows;
  if (const auto* const grid = std::get_if<AprilGrid>(&board.pattern)) {
    const double pitch = grid->tag_size * (1 + grid->tag_spacing);
    rows = {tags_of(board), pitch, grid->rows, "tagRows", "tags"};
  } else if (const auto* const charuco = std::get_if<Charuco>(&board.pattern)) {
    rows = {tags_of(board), -charuco->square_size, charuco->square_rows, "squareRows", "squares"};
  } else {
    return std::nullopt;
  }
  for (const TargetPoint& point : target_points(board))
    rows.points.emplace(point.id, point.position.head<2>());
  return rows;
}

// The picture shows much of the board before this row, and its homography puts much of the row, and
// half of the distance to the next one, inside of the picture.
bool has_room(const DetectedPicture& picture, const TagRows& rows, int row) {
  std::vector<Vector2d> points;
  std::vector<Eigen::Vector3d> rays;
  const Vector2d middle = image_centre(picture.size);
  const double scale = picture.size.width;
  for (const Observation& seen : picture.view.observations) {
    const auto point = rows.points.find(seen.id);
    if (point == rows.points.end() || !rows.is_before(point->second, row)) continue;
    points.push_back(point->second);
    rays.push_back(((seen.pixel - middle) / scale).homogeneous());
  }
  const auto before = std::ranges::count_if(
      rows.points, [&](const auto& point) { return rows.is_before(point.second, row); });
  if (points.size() < 4 ||
      static_cast<double>(points.size()) < policy::kShownShare * static_cast<double>(before))
    return false;
  const auto pixels = homography(points, rays);
  const auto is_inside = [&](const Eigen::Vector3d& corner) {
    const Vector2d beyond = corner.head<2>() + Vector2d(0, rows.step / 2);
    const Eigen::Vector3d ray = *pixels * beyond.homogeneous();
    return ray.z() > 0 && contains(picture.size, scale * ray.hnormalized() + middle);
  };
  double of_row = 0, inside = 0;
  for (const Tag& tag : rows.tags) {
    if (!pixels || rows.row_of(tag) != row) continue;
    ++of_row;
    inside += std::ranges::all_of(tag_corners(tag), is_inside);
  }
  return of_row > 0 && inside >= policy::kShownShare * of_row;
}

std::vector<std::size_t> pictures_with_room(const std::vector<DetectedPicture>& found,
                                            const TagRows& rows, int row) {
  std::vector<std::size_t> pictures;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (has_room(found[i], rows, row)) pictures.push_back(i);
  return pictures;
}

// The number of rows up to the last one that touches a seen point.
int num_touched(const std::vector<DetectedPicture>& found, const TagRows& rows) {
  int touched = 0;
  for (const DetectedPicture& picture : found)
    for (const Observation& seen : picture.view.observations)
      if (const auto point = rows.points.find(seen.id); point != rows.points.end()) {
        const double row = rows.row_at(point->second.y());
        touched = std::max(touched, static_cast<int>(std::floor(row + 1.0 / 2 + kRowRounding)) + 1);
      }
  return touched;
}

// The number of rows up to the last one with a marker that a picture surely shows.
int num_with_markers(const Image8& image, const Board& board, const TagRows& rows) {
  DetectOptions options;
  options.refinement = Refinement::edges;
  TagSearch search({&board}, options);
  const PictureToSearch picture(image);
  std::map<int, int> row_of;
  for (const Tag& tag : rows.tags) row_of.emplace(tag.id, rows.row_of(tag));
  int last = -1;
  const SeenTags seen = search.find(picture.pixels);
  for (const FoundTag& tag : seen.completions.front().tags)
    if (is_sure(picture.pixels, tag, search.family())) last = std::max(last, row_of.at(tag.id));
  return last + 1;
}

// The number of rows that the pictures show; 0 if that is not known. The corners of a ChArUco board
// do not tell: the lower edge of its last row is found as corners, too.
int num_shown(const std::vector<ImageSource>& images, const std::vector<DetectedPicture>& found,
              const Board& board, const TagRows& rows) {
  const int touched = num_touched(found, rows);
  if (touched == 0 || std::holds_alternative<AprilGrid>(board.pattern)) return touched;
  std::vector<std::size_t> pictures = pictures_with_room(found, rows, touched - 1);
  if (pictures.size() < policy::kPicturesWithRoom) return 0;
  // Those with the most corners show the most of the board.
  std::ranges::stable_sort(pictures, std::ranges::greater(),
                           [&](std::size_t i) { return found[i].view.observations.size(); });
  int shown = 0;
  for (std::size_t i = 0; i < policy::kPicturesWithRoom && shown < rows.count; ++i)
    shown = std::max(shown, num_with_markers(images[pictures[i]].load(), board, rows));
  return shown;
}

}  // namespace

std::optional<TargetMistake> missing_rows(const std::vector<ImageSource>& images,
                                          const std::vector<DetectedPicture>& found,
                                          const Board& board) {
  const auto rows = rows_of(board);
  if (!rows) return std::nullopt;
  const int shown = num_shown(images, found, board, *rows);
  if (shown == 0 || shown == rows->count) return std::nullopt;
  const std::size_t with_room = pictures_with_room(found, *rows, shown).size();
  if (with_room < policy::kPicturesWithRoom) return std::nullopt;
  return TargetMistake{
      "wrong rows",
      fmt::format("the pictures show {} of the {} rows of {}, although {} have room for the next "
                  "one; if the board has no more, write {}: {}",
                  shown, rows->count, rows->parts, with_room, rows->key, shown)};
}

}  // namespace tagcal::internal
