#include "tagcal/detect/mistakes/mistakes.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/internal/overloaded.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNeighbours = 4;  // numeric: of each tag, those on its sides
constexpr int kMostColumns = 40;        // numeric: of candidates, a limit of work

// A tag as another one sees it: the centre in the other's frame, unit its side.
struct Neighbour {
  int from = 0;
  int to = 0;
  Vector2d offset = Vector2d::Zero();
};

// The place of a tag on the board by its id, in any unit, x right and y up; no value without one.
using Layout = std::function<std::optional<Vector2d>(int id)>;

struct Agreement {
  double share = 0;  // of the neighbours that are where the layout puts them
  double scale = 0;  // sides of a tag in a unit of the layout
};

// The centre of another tag in the frame of this one: origin at its centre, unit its side.
std::optional<Vector2d> centre_seen_from(const Quad& from, const Quad& other) {
  constexpr double h = 1.0 / 2;
  const Vector2d corners[4] = {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
  Eigen::Vector3d rays[4];
  const Vector2d middle = centre_of(from);
  for (std::size_t i = 0; i < 4; ++i) rays[i] = (from[i] - middle).homogeneous();
  const auto pixels_from_tag = homography(corners, rays);
  if (!pixels_from_tag) return std::nullopt;
  // The diagonals meet at the centre, under perspective too.
  const auto line = [&](std::size_t a, std::size_t b) {
    return Eigen::Vector3d((other[a] - middle).homogeneous())
        .cross(Eigen::Vector3d((other[b] - middle).homogeneous()));
  };
  return (pixels_from_tag->inverse() * line(0, 2).cross(line(1, 3))).hnormalized();
}

std::vector<Neighbour> neighbours_in(const SeenQuads& seen) {
  std::vector<Neighbour> result;
  for (const auto& [id, quad] : seen) {
    std::vector<std::pair<double, int>> others;
    for (const auto& [other, there] : seen)
      if (other != id) others.emplace_back((centre_of(there) - centre_of(quad)).norm(), other);
    std::ranges::sort(others);
    others.resize(std::min(others.size(), kNeighbours));
    for (const auto& [distance, other] : others)
      if (const auto offset = centre_seen_from(quad, seen.at(other)))
        result.push_back({id, other, *offset});
  }
  return result;
}

Agreement agreement(const std::vector<Neighbour>& neighbours, const Layout& layout) {
  std::vector<std::pair<Vector2d, Vector2d>> pairs;  // in the picture, and in the layout
  std::vector<double> scales;
  for (const Neighbour& n : neighbours) {
    const auto from = layout(n.from), to = layout(n.to);
    if (!from || !to || *from == *to) continue;
    pairs.emplace_back(n.offset, *to - *from);
    scales.push_back(n.offset.norm() / pairs.back().second.norm());
  }
  if (pairs.size() < policy::kFewestLayoutPairs) return {};
  Agreement result;
  result.scale = median(std::move(scales));
  const auto agrees = [&](const auto& pair) {
    return (pair.first / result.scale - pair.second).norm() < policy::kLayoutTolerance;
  };
  result.share = static_cast<double>(std::ranges::count_if(pairs, agrees)) /
                 static_cast<double>(neighbours.size());
  return result;
}

bool is_sure(const Agreement& agreement) { return agreement.share > policy::kLayoutSureShare; }

// A shifted pattern moves only the markers at the ends of the rows, so that most pairs agree.
bool is_refuted_by(const Agreement& own, const Agreement& other) {
  return is_sure(other) && other.share - own.share > 1 - policy::kLayoutSureShare;
}

// A board's ids in their order: the layout if they begin with this one.
struct Ids {
  std::function<Layout(int first)> layout;
  int first = 0;   // by the target file
  int count = 0;   // of the board
  int period = 1;  // of ids, after which the layout repeats
  const char* key = "";
};

bool has_strange(const SeenQuads& seen, const Ids& ids) {
  return !seen.empty() &&
         (seen.begin()->first < ids.first || seen.rbegin()->first >= ids.first + ids.count);
}

// Tags that their neighbours place where a board has them that begins with another id. Which one is
// sure if the picture shows the first row and the last.
std::vector<TargetMistake> first_id_mistakes(const std::vector<Neighbour>& neighbours,
                                             const Agreement& own, const SeenQuads& seen,
                                             const Ids& ids) {
  if (seen.empty()) return {};
  const int least = seen.begin()->first, most = seen.rbegin()->first;
  for (int first = least; first > least - ids.period && first >= 0; --first) {
    if (first == ids.first || most >= first + ids.count) continue;
    const Agreement other = agreement(neighbours, ids.layout(first));
    // Half of the pairs that disagree: neither is right beside tags of something else.
    if (!is_sure(other) || 2 * (1 - other.share) >= 1 - own.share) continue;
    const bool is_whole = most >= first + ids.count - ids.period;
    return {{kWrongFirstId,
             fmt::format("the ids in the picture, {} to {}, are in the places of a board whose ids "
                         "begin with {}, but the target file says {}; write {}: {}{}",
                         least, most, first, ids.first, ids.key, first,
                         is_whole ? "" : ", if the picture shows the board's first row"),
             true}};
  }
  return {};
}

// ---- AprilGrid

Layout grid_layout(int columns, int first_id) {
  return [=](int id) -> std::optional<Vector2d> {
    if (id < first_id) return std::nullopt;
    return Vector2d((id - first_id) % columns, (id - first_id) / columns);
  };
}

std::vector<TargetMistake> grid_mistakes(const AprilGrid& grid, const SeenQuads& seen) {
  const std::vector<Neighbour> neighbours = neighbours_in(seen);
  const Agreement own = agreement(neighbours, grid_layout(grid.columns, grid.first_id));
  const Ids ids{[&](int first) { return grid_layout(grid.columns, first); }, grid.first_id,
                grid.columns * grid.rows, grid.columns, "first_id"};
  const auto of_first_id = [&] { return first_id_mistakes(neighbours, own, seen, ids); };
  if (has_strange(seen, ids))
    if (auto mistakes = of_first_id(); !mistakes.empty()) return mistakes;
  if (!is_sure(own)) {
    for (int columns = 1; columns <= kMostColumns; ++columns)
      if (is_refuted_by(own, agreement(neighbours, grid_layout(columns, grid.first_id))))
        return {{"wrong columns",
                 fmt::format("the ids in the picture count {} tags in a row, but the target file "
                             "says {}; write tagCols: {}",
                             columns, grid.columns, columns),
                 true}};
    return of_first_id();
  }
  const double spacing = own.scale - 1;
  if (std::abs(spacing - grid.tag_spacing) < policy::kSpacingTolerance) return {};
  const bool is_metres =
      std::abs(grid.tag_spacing / grid.tag_size - spacing) < policy::kSpacingTolerance;
  return {{"wrong tag spacing",
           fmt::format(
               "the gap is {:.2f} of a tag's side in the picture, {:.4g} in the target file{}; "
               "write tagSpacing: {:.2f}",
               spacing, grid.tag_spacing,
               is_metres ? ", which looks like metres, but must be gap / tag size" : "", spacing),
           true}};
}

// ---- ChArUco

// The places of the markers of a board with as many columns of squares, and as many rows as the
// ids need, in squares from the upper left. `shifted`: the upper left square is white.
Layout marker_layout(int columns, bool shifted, int first_id, int last_id) {
  Charuco board{columns, 2, 2, 1, {}, shifted, 0, first_id};
  while (columns * board.square_rows / 2 <= last_id - first_id) board.square_rows += 2;
  std::map<int, Vector2d> places;
  for (const Tag& tag : tags_of({board, {}}))
    places[tag.id] = tag.board_from_tag.translation().head<2>() / board.square_size;
  return [places = std::move(places)](int id) -> std::optional<Vector2d> {
    const auto place = places.find(id);
    return place == places.end() ? std::nullopt : std::optional(place->second);
  };
}

// The squares of a board, as its markers in a picture count them.
struct Squares {
  int columns = 0;
  bool shifted = false;
};

// The keys and values to write instead of the squares of the file.
std::string squares_text(const Charuco& board, const Squares& seen) {
  const bool is_exchanged = seen.columns == board.square_rows;
  const bool is_one_less = seen.columns == board.square_columns + 1;
  const int rows = is_exchanged  ? board.square_columns
                   : is_one_less ? board.square_rows + 1
                                 : board.square_rows;
  std::string text = fmt::format(
      "the markers in the picture count {} squares in a row, but the target file says {}",
      seen.columns, board.square_columns);
  if (is_exchanged && !is_one_less) text += ": columns and rows are exchanged";
  if (is_one_less) text += ": it seems to count the corners between the squares";
  text += fmt::format("; write squareCols: {}", seen.columns);
  if (is_exchanged || is_one_less) text += fmt::format(", squareRows: {}", rows);
  return text + (seen.shifted && !board.legacy ? ", legacy: true" : "");
}

// The same for the colours, of a board whose upper left square is white if `shifted`.
std::string pattern_text(const Charuco& board, bool shifted) {
  const std::string seen = fmt::format("the upper left square of the board in the picture is {}, ",
                                       shifted ? "white" : "black");
  if (shifted && board.square_rows % 2 == 1)
    return seen + fmt::format(
                      "which an odd number of rows does not allow, but the target file "
                      "says squareRows: {}; count the rows of squares and write their "
                      "even number{}",
                      board.square_rows, board.legacy ? "" : ", legacy: true");
  return seen + fmt::format("but the target file says legacy: {}; write legacy: {}", board.legacy,
                            shifted);
}

std::optional<Squares> other_squares(const std::vector<Neighbour>& neighbours, const Agreement& own,
                                     int first_id, int last_id) {
  for (int columns = 2; columns <= kMostColumns; ++columns)
    for (const bool shifted : {false, true})
      if (is_refuted_by(own,
                        agreement(neighbours, marker_layout(columns, shifted, first_id, last_id))))
        return Squares{columns, shifted};
  return std::nullopt;
}

std::vector<TargetMistake> charuco_mistakes(const Charuco& board, const SeenQuads& seen) {
  const std::vector<Neighbour> neighbours = neighbours_in(seen);
  if (neighbours.empty()) return {};
  const int first = board.first_marker_id, last = seen.rbegin()->first;
  const bool is_shifted = board.legacy && board.square_rows % 2 == 0;
  const Agreement own =
      agreement(neighbours, marker_layout(board.square_columns, is_shifted, first, last));
  const Ids ids{[&](int id) { return marker_layout(board.square_columns, is_shifted, id, last); },
                first, static_cast<int>(tags_of({board, {}}).size()), board.square_columns,
                "first_marker_id"};
  const auto of_first_id = [&] { return first_id_mistakes(neighbours, own, seen, ids); };
  if (has_strange(seen, ids))
    if (auto mistakes = of_first_id(); !mistakes.empty()) return mistakes;
  if (!is_sure(own)) {
    const auto other = other_squares(neighbours, own, first, last);
    if (!other) return of_first_id();
    if (other->columns == board.square_columns)
      return {{"wrong pattern", pattern_text(board, other->shifted), true}};
    return {{"wrong squares", squares_text(board, *other), true}};
  }
  const double share = 1 / own.scale, stated = board.marker_size / board.square_size;
  if (std::abs(share - stated) < policy::kMarkerShareTolerance) return {};
  return {{kWrongMarkerSize,
           fmt::format("a marker is {:.2f} of a square in the picture, {:.2f} in the target file; "
                       "if squareSize is right, write markerSize: {:.3g}",
                       share, stated, share * board.square_size),
           false}};
}

}  // namespace

SeenQuads quads_of(const View& view) {
  std::map<int, int> count;
  SeenQuads quads;
  for (const Observation& seen : view.observations) {
    if (seen.id.corner < 0 || seen.id.corner > 3) continue;
    quads[seen.id.tag_id][static_cast<std::size_t>(seen.id.corner)] = seen.pixel;
    ++count[seen.id.tag_id];
  }
  std::erase_if(quads, [&](const auto& tag) { return count.at(tag.first) != 4; });
  return quads;
}

std::vector<TargetMistake> layout_mistakes(const Board& board, const SeenQuads& seen) {
  return std::visit(
      Overloaded{[&](const AprilGrid& grid) { return grid_mistakes(grid, seen); },
                 [&](const Charuco& charuco) { return charuco_mistakes(charuco, seen); },
                 [](const auto&) { return std::vector<TargetMistake>(); }},
      board.pattern);
}

}  // namespace tagcal::internal
