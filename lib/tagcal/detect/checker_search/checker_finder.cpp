#include "tagcal/detect/checker_search/checker_finder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "tagcal/detect/checker_search/grid_numbering.hpp"
#include "tagcal/detect/checker_search/grid_squares.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr int kLeastSidePx = 100;  // of a halved picture, as a limit of work

// Removes outermost lines with few junctions: they are not the board's.
void trim(JunctionGrid& grid) {
  const auto cut_one = [&](auto member) {
    std::map<int, int> count;  // of junctions, by line
    for (const auto& [cell, at] : grid) ++count[cell.*member];
    int most = 0;
    for (const auto& [line, n] : count) most = std::max(most, n);
    for (const int line : {count.begin()->first, count.rbegin()->first}) {
      if (count[line] >= policy::kMinLineShare * most) continue;
      std::erase_if(grid, [&](const auto& node) { return node.first.*member == line; });
      return true;
    }
    return false;
  };
  while (!grid.empty() && (cut_one(&GridCell::first) || cut_one(&GridCell::second))) {
  }
}

// The grids of the junctions of a picture that was halved as often as given, in pixels of the
// original.
std::vector<JunctionGrid> grids_of(const ImageView8& picture,
                                   const std::vector<Junction>& junctions, int halvings,
                                   bool follows_lines) {
  std::vector<JunctionGrid> grids = junction_grids(junctions, follows_lines);
  std::ranges::for_each(grids, trim);
  std::erase_if(grids, [&](const JunctionGrid& grid) {
    return grid.size() < 4 || !shows_squares(picture, grid);
  });
  const double scale = std::exp2(halvings);
  for (JunctionGrid& grid : grids)
    for (auto& [cell, at] : grid)
      at = scale * at + Vector2d::Constant((scale - 1) / 2);  // pixel centres at whole numbers
  std::ranges::stable_sort(grids, std::ranges::greater(),
                           [](const JunctionGrid& grid) { return grid.size(); });
  return grids;
}

Vector2d middle_of(const JunctionGrid& grid) {
  Vector2d sum = Vector2d::Zero();
  for (const auto& [cell, at] : grid) sum += at;
  return sum / static_cast<double>(grid.size());
}

bool overlap(const JunctionGrid& a, const JunctionGrid& b) {
  const double size = (a.begin()->second - a.rbegin()->second).norm();
  return (middle_of(a) - middle_of(b)).norm() < size / 4;
}

// True if most junctions of a grid are also in another, which has more of them.
bool continues(const JunctionGrid& larger, const JunctionGrid& grid) {
  if (larger.size() <= grid.size()) return false;
  const Vector2d& one = grid.begin()->second;
  double step = std::numeric_limits<double>::infinity();
  for (auto node = std::next(grid.begin()); node != grid.end(); ++node)
    step = std::min(step, (node->second - one).norm());
  const auto is_in_larger = [&](const auto& node) {
    return std::ranges::any_of(larger, [&](const auto& other) {
      return (other.second - node.second).norm() < policy::kMaxMoveShare * step;
    });
  };
  return 2 * std::ranges::count_if(grid, is_in_larger) > static_cast<std::ptrdiff_t>(grid.size());
}

bool is_final(const SeenChecker& seen) {
  return seen.answer == CheckerAnswer::found || seen.answer == CheckerAnswer::seen_twice;
}

std::string other_grid_text(const std::string& name, const CheckerCell& size,
                            const Checkerboard& board) {
  const auto& [columns, rows] = size;
  if (columns <= board.columns && rows <= board.rows)
    return fmt::format(
        "{} is not seen whole: the largest grid has {} x {}. Parts of a board without markers "
        "cannot be numbered",
        name, columns, rows);
  return fmt::format("a grid of {} x {} corners is seen, not {}", columns, rows, name);
}

}  // namespace

CheckerCell size_beside(const CheckerCell& size, const Checkerboard& board) {
  const auto& [a, b] = size;
  const bool is_inside = a <= board.columns && b <= board.rows;
  const bool is_inside_turned = b <= board.columns && a <= board.rows;
  const bool is_wide = board.columns >= board.rows;
  const bool is_turned = is_inside != is_inside_turned ? is_inside_turned : (a >= b) != is_wide;
  return is_turned ? CheckerCell{b, a} : size;
}

std::string why_not_text(const SeenChecker& seen, const Board& board) {
  const Checkerboard squares = checkers(board).value();
  const std::string name =
      fmt::format("the checkerboard of {} x {} corners", squares.columns, squares.rows);
  switch (seen.answer) {
    case CheckerAnswer::found:
      return {};
    case CheckerAnswer::no_grid:
      return tag_kind(board) ? "no marker of the ChArUco board found" : "no checkerboard found";
    case CheckerAnswer::other_grid:
      return other_grid_text(name, size_beside(seen.size, squares), squares);
    case CheckerAnswer::not_fitted:
      return fmt::format("{}: its corners do not look like its pattern", name);
    case CheckerAnswer::seen_twice:
      return fmt::format("{} is seen more than once, so it is not reported", name);
  }
  return {};
}

CheckerFinder::CheckerFinder(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
    : camera_(options.camera) {
  for (const PlacedBoard& placed : boards) {
    const Board& board = placed.board;
    const auto squares = checkers(board);
    if (!squares) continue;
    boards_.push_back(&board);
    Target target{&board, *squares, CheckerPrint(board), {}};
    if (tag_kind(board)) {
      // The markers only lead to the corners, so that their sides are enough.
      DetectOptions of_markers = options;
      of_markers.refinement = Refinement::edges;
      target.markers.emplace(std::vector<const Board*>{&board}, of_markers);
    }
    targets_.push_back(std::move(target));
  }
}

std::vector<SeenChecker> CheckerFinder::find(const ImageView8& image) {
  std::vector<SeenChecker> result;
  for (Target& target : targets_)
    result.push_back(target.markers ? find_charuco(image, target) : SeenChecker());
  if (std::ranges::all_of(targets_, [](const Target& t) { return t.markers.has_value(); }))
    return result;
  find_junctions_of_levels(image);
  for (const bool follows_lines : {false, true}) {
    follows_lines_ = follows_lines;
    levels_.clear();
    for (const auto& [half, junctions] : pictures_) {
      const int halvings = static_cast<int>(levels_.size());
      const ImageView8 picture = halvings == 0 ? image : ImageView8(half);
      levels_.push_back(grids_of(picture, junctions, halvings, follows_lines));
    }
    find_plain(image, result);
    if (std::ranges::all_of(result, is_final)) break;
  }
  return result;
}

void CheckerFinder::find_plain(const ImageView8& image, std::vector<SeenChecker>& result) const {
  for (const std::vector<JunctionGrid>& grids : levels_) {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (targets_[i].markers || is_final(result[i])) continue;
      SeenChecker seen = find_plain(image, targets_[i], grids);
      if (is_final(seen) || seen.answer > result[i].answer) result[i] = std::move(seen);
    }
  }
}

// Halved pictures show large squares with less noise; results of the finest level take precedence.
void CheckerFinder::find_junctions_of_levels(const ImageView8& image) {
  pictures_.clear();
  pictures_.push_back({{}, find_junctions(image)});
  for (Image8 half = halved(image); std::min(half.width(), half.height()) >= kLeastSidePx;) {
    Image8 next = halved(half);
    std::vector<Junction> junctions = find_junctions(half);
    pictures_.push_back({std::move(half), std::move(junctions)});
    half = std::move(next);
  }
}

const JunctionGrid* CheckerFinder::larger_grid(const JunctionGrid& grid,
                                               const Target& target) const {
  for (const std::vector<JunctionGrid>& grids : levels_)
    for (const JunctionGrid& other : grids)
      if (continues(other, grid) && !is_of_size(other, target.print)) return &other;
  return nullptr;
}

std::optional<CheckerFinder::Fitted> CheckerFinder::fitted(const ImageView8& image,
                                                           const Target& target,
                                                           const JunctionGrid& grid) const {
  CheckerPrint print = target.print;
  const auto numbering = numbering_of(grid, print);
  if (!numbering) return std::nullopt;
  print.set_starts_black(numbering->starts_black());
  std::vector<CheckerPlace> places;
  for (int row = 0; row < print.rows(); ++row)
    for (int column = 0; column < print.columns(); ++column)
      if (const auto node = grid.find(numbering->junction({column, row})); node != grid.end())
        places.push_back({Vector2d(column, row), node->second});
  const CheckerFitter fitter(image, print, camera_);
  CheckerCorners corners = fitter.fit(places);
  if (follows_lines_ && !fitter.drop_outliers(corners)) return std::nullopt;
  if (!is_verified(corners, print)) return std::nullopt;
  fitter.fit_under_lens(corners);
  if (!is_verified(corners, print)) return std::nullopt;
  return Fitted{std::move(corners), print.starts_black()};
}

SeenChecker CheckerFinder::find_plain(const ImageView8& image, const Target& target,
                                      const std::vector<JunctionGrid>& grids) const {
  SeenChecker seen;
  // Smaller grids are in most pictures.
  const auto shown = std::ranges::find_if(grids, [&](const JunctionGrid& grid) {
    const auto [columns, rows] = size_of(grid);
    return std::min(columns, rows) >= policy::kGridOfOtherTarget || is_of_size(grid, target.print);
  });
  if (shown == grids.end()) return seen;
  seen.size = size_of(*shown);
  seen.answer = CheckerAnswer::other_grid;
  const JunctionGrid* first = nullptr;
  for (const JunctionGrid& grid : grids) {
    if (!is_of_size(grid, target.print)) continue;
    if (first && overlap(*first, grid)) continue;
    if (const JunctionGrid* const larger = larger_grid(grid, target)) {
      if (!first) seen.size = size_of(*larger);
      continue;
    }
    const auto corners = fitted(image, target, grid);
    if (!corners) {
      if (!first) seen.answer = CheckerAnswer::not_fitted;
      continue;
    }
    if (first) return {CheckerAnswer::seen_twice, seen.size, {}};
    first = &grid;
    seen.answer = CheckerAnswer::found;
    seen.corners = observations_of(corners->corners, target.squares);
    seen.starts_black = corners->starts_black;
    seen.follows_lines = follows_lines_;
  }
  return seen;
}

SeenChecker CheckerFinder::find_charuco(const ImageView8& image, Target& target) const {
  SeenChecker seen;
  std::map<int, Tag> by_id;
  for (const Tag& tag : tags_of(*target.board)) by_id.emplace(tag.id, tag);
  std::vector<CheckerPlace> places;
  for (const Completion& completion : target.markers->find(image).completions) {
    for (const FoundTag& found : completion.tags) {
      const auto on_board = tag_corners(by_id.at(found.id));
      for (std::size_t k = 0; k < 4; ++k)
        places.push_back({on_board[k].head<2>() / target.squares.column_spacing, found.corners[k]});
    }
  }
  if (places.empty()) return seen;
  const CheckerFitter fitter(image, target.print, camera_);
  CheckerCorners corners = fitter.fit(places);
  fitter.fit_under_lens(corners);
  seen.answer = corners.empty() ? CheckerAnswer::not_fitted : CheckerAnswer::found;
  seen.corners = observations_of(corners, target.squares);
  return seen;
}

}  // namespace tagcal::internal
