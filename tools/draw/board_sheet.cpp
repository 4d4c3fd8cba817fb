#include "draw/board_sheet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/overloaded.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr double kMinMarginMm = 10;
constexpr double kStepMm = 0.5;           // of the sizes that --paper picks
constexpr double kMm = 1000;              // of a metre
constexpr std::size_t kMostIds = 6;       // by number in the caption
constexpr std::size_t kMostLetters = 40;  // of a file's name in the caption

TagFamily family_of(const Board& board, const TagFamilies& families) {
  const auto kind = tag_kind(board);
  return kind ? families.at(kind->family) : TagFamily{};
}

// A tag needs a white frame, two cells wide; a checkerboard has white squares at its border, and
// needs half a square more beside its black ones; discs need as much white as between them.
double margin_mm(const Board& board, const TagFamilies& families) {
  double margin = kMinMarginMm;
  if (const auto squares = checkers(board))
    return std::max(margin, kMm * std::min(squares->column_spacing, squares->row_spacing) / 2);
  if (const auto* const grid = std::get_if<CircleGrid>(&board.pattern))
    return std::max(margin, kMm * (centre_distance(*grid) - grid->diameter));
  const TagFamily family = family_of(board, families);
  for (const Tag& tag : tags_of(board))
    margin = std::max(margin, 2 * kMm * tag.size / family.width_at_border);
  return margin;
}

std::vector<Contour> ink_mm(const Board& board, const TagFamilies& families) {
  std::vector<Contour> ink;
  for (const InkCell& cell : ink_cells(board, family_of(board, families))) {
    Contour& outline = ink.emplace_back();
    for (const Eigen::Vector3d& corner : cell) outline.emplace_back(kMm * corner.head<2>());
  }
  return ink;
}

Vector2d extent(const std::vector<Contour>& ink) {
  Eigen::AlignedBox2d box;
  for (const Contour& outline : ink)
    for (const Vector2d& corner : outline) box.extend(corner);
  return box.sizes();
}

std::string mm(double metres) { return fmt::format("{:g}", std::round(metres * 1e6) / 1e3); }

std::string ids_text(const Board& board) {
  std::vector<int> ids;
  for (const Tag& tag : tags_of(board)) ids.push_back(tag.id);
  std::ranges::sort(ids);
  if (ids.size() == 1) return fmt::format("id {}", ids[0]);
  const bool all = ids.back() - ids.front() + 1 == static_cast<int>(ids.size());
  if (all) return fmt::format("ids {} to {}", ids.front(), ids.back());
  if (ids.size() <= kMostIds) return fmt::format("ids {}", fmt::join(ids, ", "));
  return fmt::format("{} ids from {} to {}", ids.size(), ids.front(), ids.back());
}

std::string squares_text(const Checkerboard& squares) {
  const std::string width = mm(squares.column_spacing);
  const bool same = squares.column_spacing == squares.row_spacing;
  return fmt::format("{} x {} squares of {} mm", squares.columns + 1, squares.rows + 1,
                     same ? width : width + " x " + mm(squares.row_spacing));
}

// Second line of the caption: the markers.
std::string pattern_text(const Board& board) {
  return std::visit(
      Overloaded{
          [](const Points&) { return std::string(); },
          [](const Checkerboard& squares) {
            return fmt::format("{} square at the lower left",
                               squares.starts_black ? "black" : "white");
          },
          [&](const Charuco& charuco) {
            return fmt::format("{}, {}, markers of {} mm{}", charuco.dictionary, ids_text(board),
                               mm(charuco.marker_size), charuco.legacy ? ", legacy layout" : "");
          },
          [](const CircleGrid& grid) {
            return fmt::format("{}, {} mm apart", grid.asymmetric ? "asymmetric" : "symmetric",
                               mm(grid.spacing));
          },
          [&](const auto& tags) {
            return fmt::format("{}, {}, border of {} cell{}", tags.family, ids_text(board),
                               tags.border_bits, tags.border_bits == 1 ? "" : "s");
          }},
      board.pattern);
}

SheetFrame frame_of(const Board& board, const TagFamilies& families, const std::string& name,
                    const std::optional<Paper>& page) {
  const bool short_name = name.size() <= kMostLetters;
  SheetFrame frame{margin_mm(board, families),
                   {(short_name ? name + ": " : "") + size_text(board),
                    pattern_text(board) + "; print at 100 %"}};
  if (!page) return frame;
  frame.page_mm = Vector2d(page->width_mm, page->height_mm);
  // To fill the page, the white around the board is only as wide as printers and tags need.
  frame.margin_mm = std::max(kMinMarginMm, frame.margin_mm / 2);
  return frame;
}

// The length that --paper picks, in metres.
double leading_size(const Board& board) {
  if (const auto* const grid = std::get_if<CircleGrid>(&board.pattern)) return grid->spacing;
  const auto squares = checkers(board);
  return squares ? squares->column_spacing : tags_of(board).front().size;
}

Board resized(const Board& board, double size_m) {
  const double scale = size_m / leading_size(board), step_m = kStepMm / kMm;
  BoardPattern pattern = board.pattern;
  std::visit(Overloaded{[](Points&) {},
                        [&](Tags& tags) {
                          for (Tag& tag : tags.tags) {
                            const Pose& pose = tag.board_from_tag;
                            tag.size *= scale;
                            tag.board_from_tag = Pose(pose.rotation(), scale * pose.translation());
                          }
                        },
                        [&](AprilGrid& grid) { grid.tag_size = size_m; },
                        [&](Checkerboard& squares) {
                          const bool square = squares.row_spacing == squares.column_spacing;
                          squares.row_spacing = square ? size_m : squares.row_spacing * scale;
                          squares.column_spacing = size_m;
                        },
                        [&](Charuco& charuco) {
                          const double steps = std::floor(charuco.marker_size * scale / step_m);
                          charuco.marker_size = std::max(1.0, steps) * kStepMm / kMm;
                          charuco.square_size = size_m;
                        },
                        [&](CircleGrid& grid) {
                          grid.diameter *= scale;
                          grid.spacing = size_m;
                        }},
             pattern);
  return make_board(std::move(pattern), board.substrate);
}

// The greatest number of steps whose board fits the page; 0 if none does.
int most_steps(const Board& board, const TagFamilies& families, const std::string& name,
               const Paper& page) {
  const Vector2d ink = extent(ink_mm(board, families));  // grows with the size
  const double size_mm = kMm * leading_size(board);
  const double longest = std::max(page.width_mm, page.height_mm);
  for (int steps = static_cast<int>(longest / kStepMm); steps > 0; --steps) {
    const double size_m = steps * kStepMm / kMm;
    if ((ink * (size_m * kMm / size_mm)).maxCoeff() > longest) continue;
    const Board fitted = resized(board, size_m);
    const Vector2d needed =
        needed_size(ink * (size_m * kMm / size_mm), frame_of(fitted, families, name, page));
    if (needed.x() <= page.width_mm && needed.y() <= page.height_mm) return steps;
  }
  return 0;
}

}  // namespace

std::string size_text(const Board& board) {
  return std::visit(
      Overloaded{
          [](const Points& measured) { return fmt::format("{} points", measured.points.size()); },
          [](const Tags& single) {
            const std::size_t n = single.tags.size();
            const auto [least, greatest] = std::ranges::minmax(single.tags, {}, &Tag::size);
            const bool same = least.size == greatest.size;
            return fmt::format("{} tag{} of {}{} mm", n, n == 1 ? "" : "s",
                               same ? "" : mm(least.size) + " to ", mm(greatest.size));
          },
          [](const AprilGrid& grid) {
            return fmt::format("{} x {} tags of {} mm, gaps of {} mm", grid.columns, grid.rows,
                               mm(grid.tag_size), mm(grid.tag_size * grid.tag_spacing));
          },
          [](const CircleGrid& grid) {
            return fmt::format("{} x {} circles of {} mm", grid.columns, grid.rows,
                               mm(grid.diameter));
          },
          [](const Checkerboard& squares) { return squares_text(squares); },
          [&](const Charuco&) { return squares_text(checkers(board).value()); }},
      board.pattern);
}

double least_cell_mm(const Board& board, const TagFamilies& families) {
  double least = std::numeric_limits<double>::infinity();
  const auto kind = tag_kind(board);
  for (const Tag& tag : tags_of(board))
    least = std::min(least, tag.size / families.at(kind->family).width_at_border);
  if (const auto squares = checkers(board))
    least = std::min({least, squares->column_spacing, squares->row_spacing});
  if (const auto* const grid = std::get_if<CircleGrid>(&board.pattern))
    least = std::min(grid->diameter, centre_distance(*grid) - grid->diameter);
  return kMm * least;
}

PrintedSheet board_sheet(const Board& board, const TagFamilies& families, const std::string& name,
                         const std::optional<Paper>& page) {
  return sheet_with_scale_bar(ink_mm(board, families), frame_of(board, families, name, page));
}

FittedBoard fitted_board(const Board& board, const TagFamilies& families, const std::string& name,
                         const Paper& paper, bool landscape) {
  const int lying = most_steps(board, families, name, paper.landscape());
  const int upright = landscape ? 0 : most_steps(board, families, name, paper);
  const int steps = std::max(lying, upright);
  if (steps == 0)
    throw Error(fmt::format(
        "--paper: {} is too small: tags, squares or spacings would have less than {} mm",
        paper.name, kStepMm));
  return {resized(board, steps * kStepMm / kMm), lying > upright ? paper.landscape() : paper};
}

}  // namespace tagcal::tools
