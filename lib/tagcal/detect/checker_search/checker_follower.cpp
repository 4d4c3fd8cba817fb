// Corners of checkerboards and ChArUco boards that are followed from picture to picture.

#include <algorithm>

#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// The corners of a picture at their places in the next one.
std::vector<CheckerPlace> moved_places(const std::vector<Observation>& corners,
                                       const Checkerboard& board, const Vector2d& by) {
  std::vector<CheckerPlace> places;
  for (const Observation& seen : corners) {
    const int place = seen.id.tag_id - board.first_id;
    places.push_back({Vector2d(place % board.columns, place / board.columns), seen.pixel + by});
  }
  return places;
}

// True if a place that was predicted has no corner, and lies so far inside the picture that all
// pixels about it are there.
bool has_lost(const std::vector<CheckerPlace>& places, const CheckerCorners& corners,
              const ImageSize& size) {
  return std::ranges::any_of(places, [&](const CheckerPlace& place) {
    const auto cell = place.on_board.cast<int>();
    return !corners.contains({cell.x(), cell.y()}) &&
           is_inside({place.at, place.at, place.at, place.at}, size, policy::kTagInsidePx);
  });
}

// The four corners of a square, from its lower-left one, that were found.
std::optional<PlacedTag> square_at(const CheckerCell& cell, const CheckerCorners& corners) {
  constexpr std::array<CheckerCell, 4> kTurn = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  PlacedTag square;
  square.seen.emplace();
  for (std::size_t i = 0; i < 4; ++i) {
    const CheckerCell at{cell.first + kTurn[i].first, cell.second + kTurn[i].second};
    const auto found = corners.find(at);
    if (found == corners.end()) return std::nullopt;
    square.corners[i] = Vector2d(at.first, at.second);
    (*square.seen)[i] = found->second.at;
  }
  return square;
}

// True if most markers between the corners show their bits: corners that are off by whole squares
// show those of others.
bool shows_markers(const ImageView8& image, const Board& board, const TagFamily& family,
                   const CellSurroundings& surroundings, const CheckerCorners& corners) {
  int read = 0, agreeing = 0;
  const double side = checkers(board).value().column_spacing;
  for (const Tag& tag : tags_of(board)) {
    PlacedTag placed;
    const auto on_board = tag_corners(tag);
    for (std::size_t i = 0; i < 4; ++i) placed.corners[i] = on_board[i].head<2>() / side;
    placed.centre = centre_of(placed.corners);
    const auto cell = placed.centre.array().floor().cast<int>();
    const auto square = square_at({cell.x(), cell.y()}, corners);
    if (!square) continue;
    const auto quad = predicted(placed, {&*square}, 1);
    if (!quad || !is_inside(*quad, image.size(), 0)) continue;
    const TagAnswer answer = read_tag(image, *quad, TagCells(family, tag.id, surroundings));
    ++read;
    agreeing += answer.contrast >= policy::kMinContrast && answer.wrong_bits <= 1 &&
                answer.wrong_fixed <= policy::kTagMaxWrongFixed;
  }
  return 2 * agreeing > read;
}

}  // namespace

std::optional<SeenChecker> CheckerFinder::follow(const ImageView8& image, const Target& target,
                                                 const SeenChecker& before,
                                                 const PictureShift& shift) const {
  if (before.answer != CheckerAnswer::found || before.follows_lines) return std::nullopt;
  Eigen::AlignedBox2d box;
  for (const Observation& corner : before.corners) box.extend(corner.pixel);
  const auto by = shift.of(box);
  if (!by) return std::nullopt;
  const std::vector<CheckerPlace> places = moved_places(before.corners, target.squares, *by);
  CheckerPrint print = target.print;
  print.set_starts_black(before.starts_black);
  const CheckerFitter fitter(image, print, camera_);
  CheckerCorners corners = fitter.fit(places);
  const auto is_followed = [&] {
    return !has_lost(places, corners, image.size()) &&
           (target.markers || is_verified(corners, print));
  };
  if (!is_followed()) return std::nullopt;
  if (target.markers &&
      !shows_markers(image, *target.board, target.markers->family(),
                     cell_surroundings(*target.board, target.markers->family()), corners))
    return std::nullopt;
  fitter.fit_under_lens(corners);
  if (!is_followed()) return std::nullopt;
  SeenChecker seen = before;
  seen.corners = observations_of(corners, target.squares);
  return seen;
}

std::optional<std::vector<SeenChecker>> CheckerFinder::follow(
    const ImageView8& image, const std::vector<SeenChecker>& before,
    const PictureShift& shift) const {
  std::vector<SeenChecker> result;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    auto seen = follow(image, targets_[i], before[i], shift);
    if (!seen) return std::nullopt;
    result.push_back(std::move(*seen));
  }
  return result;
}

}  // namespace tagcal::internal
