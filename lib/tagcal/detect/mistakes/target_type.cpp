#include "tagcal/detect/mistakes/mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/detect/board_search/board_symmetry.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/internal/overloaded.hpp"

namespace tagcal::internal {
namespace {

std::string type_text(const Board& board) {
  return std::visit(
      Overloaded{[](const AprilGrid&) { return "aprilgrid"; }, [](const Tags&) { return "tags"; },
                 [](const Checkerboard&) { return "checkerboard"; },
                 [](const Charuco&) { return "charuco"; },
                 [](const CircleGrid&) { return "circlegrid"; },
                 [](const auto&) { return "points"; }},
      board.pattern);
}

std::optional<TargetMistake> mistake(const std::string& seen, const Board& board,
                                     const std::string& type, const std::string& keys) {
  if (type_text(board) == type) return std::nullopt;
  return TargetMistake{
      "wrong target_type",
      fmt::format("{}, but the target file says target_type: {}; write target_type: {}, {}", seen,
                  type_text(board), type, keys)};
}

// The tags or markers of which the picture shows the most.
std::optional<TargetMistake> other_tags(const ImageView8& image, const Board& board) {
  std::vector<TagsOfKind> kinds = search_kinds(image, kinds_of_all_targets()).kinds;
  keep_sure(image, kinds);
  const auto most =
      std::ranges::max_element(kinds, {}, [](const TagsOfKind& seen) { return seen.tags.size(); });
  if (most == kinds.end() || most->tags.size() < policy::kTagsOfOtherTarget) return std::nullopt;
  const TagKind& kind = most->kind;
  const std::size_t n = most->tags.size();
  if (!kind.family.starts_with("DICT_"))
    return mistake(fmt::format("the picture shows {} tags of {}", n, kind.family), board,
                   "aprilgrid",
                   fmt::format("family: {}, border_bits: {}", kind.family, kind.border_bits));
  const int last = std::ranges::max(most->tags, {}, &FoundTag::id).id;
  const std::string dictionary = smallest_dictionary_with(kind.family, last);
  return mistake(fmt::format("the picture shows {} markers of {}", n, dictionary), board, "charuco",
                 "dictionary: " + dictionary);
}

std::optional<TargetMistake> circle_grid(const ImageView8& image, const Board& board) {
  const auto seen = whole_grid_in(image);
  if (!seen) return std::nullopt;
  const std::string shown = "the picture shows " + name_of(*seen);
  const std::string keys = fmt::format("targetCols: {}, targetRows: {}, asymmetricGrid: {}",
                                       seen->columns, seen->rows, seen->asymmetric);
  const auto* const stated = std::get_if<CircleGrid>(&board.pattern);
  if (!stated) return mistake(shown, board, "circlegrid", keys);
  TargetMistake mistake{
      "wrong size of grid",
      fmt::format("{}, but the target file says {}; write {}", shown, name_of(*stated), keys)};
  mistake.needs_others = seen->columns <= stated->columns && seen->rows <= stated->rows &&
                         seen->asymmetric == stated->asymmetric;
  return mistake;
}

std::optional<TargetMistake> checkerboard(const ImageView8& image, const Board& board) {
  // The finder names the largest grid that is not of the size that it looks for.
  const std::vector<PlacedBoard> small = {{make_board(Checkerboard{2, 2, 1, 1}), Pose()}};
  CheckerFinder finder(small, {});
  const auto [columns, rows] = finder.find(image).front().size;
  if (std::min(columns, rows) < policy::kGridOfOtherTarget) return std::nullopt;
  return mistake(fmt::format("the picture shows a grid of {} x {} corners", columns, rows), board,
                 "checkerboard", fmt::format("targetCols: {}, targetRows: {}", columns, rows));
}

}  // namespace

std::optional<TargetMistake> target_type_mistake(const ImageView8& image,
                                                 const std::vector<PlacedBoard>& boards) {
  if (boards.empty()) return std::nullopt;  // a search for a family
  const Board& board = boards.front().board;
  for (const auto& find : {other_tags, circle_grid, checkerboard})
    if (auto mistake = find(image, board)) return mistake;
  return std::nullopt;
}

std::optional<TargetMistake> grid_size_mistake(const SeenChecker& seen, const Board& board) {
  if (seen.answer != CheckerAnswer::other_grid) return std::nullopt;
  const Checkerboard squares = checkers(board).value();
  const auto [columns, rows] = size_beside(seen.size, squares);
  TargetMistake mistake{"wrong size of grid", "", true};
  if (columns == squares.columns - 1 && rows == squares.rows - 1) {
    mistake.sentence = fmt::format(
        "the picture shows a grid of {} x {} corners, as a board of {} x {} squares has; the "
        "target "
        "file must count the corners inside, not the squares; write targetCols: {}, targetRows: {}",
        columns, rows, squares.columns, squares.rows, columns, rows);
    return mistake;
  }
  mistake.needs_others = columns <= squares.columns && rows <= squares.rows;
  mistake.sentence = fmt::format(
      "the picture shows a grid of {} x {} corners, but the target file says {} x {}; write "
      "targetCols: {}, targetRows: {}",
      columns, rows, squares.columns, squares.rows, columns, rows);
  return mistake;
}

}  // namespace tagcal::internal
