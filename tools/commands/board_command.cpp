#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "draw/board_sheet.hpp"
#include "draw/sheet.hpp"
#include "job/arguments.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxPixels = 100e6;
constexpr double kMostPages = 500;  // of --tile: a ream of paper
constexpr double kFlat_m = 1e-6;
constexpr double kDpi = 300;
constexpr double kLeastCell_mm = 0.01;    // half a dot of 1200 dpi
constexpr double kLeastPixelsOfCell = 2;  // of a PNG: fewer make cells of different widths

struct BoardArguments {
  std::string target;
  std::string out;
  double dpi = 0;  // 0: not given
  std::string paper;
  std::string tile;
  bool landscape = false;
};

double dpi_of(const BoardArguments& arguments) { return arguments.dpi > 0 ? arguments.dpi : kDpi; }

const Paper& paper_named(const std::string& name) {
  return *std::ranges::find(kPapers, name, &Paper::name);  // the option allows no other names
}

// For titles and captions.
std::string printable_name(const fs::path& file) { return one_line_text(file.filename().string()); }

void check(const BoardArguments& arguments, const std::string& kind) {
  if (kind != ".svg" && kind != ".png" && kind != ".pdf")
    throw Error(fmt::format("--out: must end in .svg, .png or .pdf, got {}", arguments.out));
  if (!arguments.tile.empty() && kind != ".pdf")
    throw Error(fmt::format("--tile: needs several pages, --out FILE.pdf, got {}", arguments.out));
  if (arguments.dpi > 0 && kind != ".png")
    throw Error(fmt::format("--dpi: belongs to a picture, --out FILE.png, got {}", arguments.out));
  if (arguments.landscape && arguments.paper.empty())
    throw Error("--landscape: belongs to --paper");
}

Board board_to_print(const std::string& file, std::vector<std::string>* warnings) {
  Board board = read_target(file, {}, warnings);
  if (point_kind(board) == PointKind::measured)
    throw Error(fmt::format("{}: no tags, squares or circles to print, only points", file));
  for (const Tag& tag : tags_of(board)) {
    for (const Eigen::Vector3d& corner : tag_corners(tag)) {
      if (std::abs(corner.z()) <= kFlat_m) continue;
      throw Error(
          fmt::format("{}: tag {} must lie in the plane z = 0 to be printed, got z = {:g} m", file,
                      tag.id, corner.z()));
    }
    if ((tag.board_from_tag.rotation_matrix() * Eigen::Vector3d::UnitZ()).z() < 0) {
      throw Error(fmt::format("{}: tag {} faces away from the printed side", file, tag.id));
    }
  }
  if (const auto ids = overlapping_tags(board))
    warnings->push_back(fmt::format("{}: tags {} and {} cover each other: neither can be detected",
                                    file, ids->first, ids->second));
  return board;
}

// Throws Error for a resolution at which a picture cannot show the cells of the board.
void check_dpi(const BoardArguments& arguments, const std::string& kind, const Board& board,
               const TagFamilies& families) {
  const double cell_mm = least_cell_mm(board, families), dpi = dpi_of(arguments);
  if (kind != ".png" || cell_mm * dpi / 25.4 >= kLeastPixelsOfCell) return;
  throw Error(fmt::format(
      "--dpi: must be {:.0f} or more, {} pixels for each cell of {:.3g} mm, got {:g}",
      std::ceil(kLeastPixelsOfCell * 25.4 / cell_mm), kLeastPixelsOfCell, cell_mm, dpi));
}

Image8 picture_of(const PrintedSheet& sheet, double dpi) {
  const ImageSize size = sheet_size(sheet, dpi / 25.4);
  if (static_cast<double>(size.width) * size.height > kMaxPixels) {
    throw Error(
        fmt::format("--dpi: the picture must have {:.0f} megapixels at most, got {}x{} at {:g}",
                    kMaxPixels / 1e6, size.width, size.height, dpi));
  }
  return sheet_image(sheet, dpi / 25.4);
}

void write_sheet(const BoardArguments& arguments, const std::string& kind,
                 const PrintedSheet& sheet, const std::string& title) {
  if (kind == ".svg")
    write_whole(arguments.out, sheet_svg(sheet, title));
  else if (kind == ".pdf")
    write_whole(arguments.out, sheet_pdf(sheet, title));
  else
    write_png(arguments.out, picture_of(sheet, dpi_of(arguments)), dpi_of(arguments));
}

bool is_target(const fs::path& file) {
  try {
    read_target(file);
  } catch (const Error&) {
    return false;
  }
  return true;
}

// The file of the board that --paper makes, beside the picture. Throws Error if it is the target,
// or another file than one of a target.
fs::path fitted_file(const BoardArguments& arguments) {
  const fs::path file = fs::path(arguments.out).replace_extension(".yaml");
  std::error_code no_such_file;
  if (fs::equivalent(file, arguments.target, no_such_file))
    throw Error(
        fmt::format("{}: --paper writes another target there, but it is the one to be read;"
                    " give --out another name",
                    file.string()));
  check_writable(file);
  if (fs::exists(file, no_such_file) && !is_target(file))
    throw Error(
        fmt::format("{}: --paper writes the target there, but it is another file; give "
                    "--out another name",
                    file.string()));
  return file;
}

TagFamilies families_of(const BoardArguments& arguments, const Board& board) {
  return naming(arguments.target, [&] {
    check_tags(board);
    return tag_families({{board, Pose()}});
  });
}

void print_on_paper(const BoardArguments& arguments, const std::string& kind, const Board& board) {
  const fs::path file = fitted_file(arguments);
  const std::string name = printable_name(file);
  const TagFamilies families = families_of(arguments, board);
  const FittedBoard fitted = naming(arguments.target, [&] {
    return fitted_board(board, families, name, paper_named(arguments.paper), arguments.landscape);
  });
  check_dpi(arguments, kind, fitted.board, families);
  const PrintedSheet sheet = naming(
      arguments.target, [&] { return board_sheet(fitted.board, families, name, fitted.page); });
  write_sheet(arguments, kind, sheet, name);
  write_target(file, fitted.board);
  say_wrote(arguments.out,
            fmt::format("{} on {}{}; print at 100 % and check the bar of 100 mm",
                        size_text(fitted.board), arguments.paper,
                        fitted.page.width_mm > fitted.page.height_mm ? ", landscape" : ""));
  say_wrote(file, fmt::format("the target to use with it, instead of {} ({})", arguments.target,
                              size_text(board)));
}

Tiling tiling_on_pages(const PrintedSheet& sheet, const Paper& paper) {
  const double pages =
      sheet.width_mm * sheet.height_mm / (paper.width_mm * paper.height_mm);  // and more
  if (pages > kMostPages)
    throw Error(fmt::format("--tile: {:.0f} x {:.0f} mm take more than {:.0f} pages of {}",
                            sheet.width_mm, sheet.height_mm, kMostPages, paper.name));
  return tiling_of(sheet, paper);
}

bool fits(const PrintedSheet& sheet, const Paper& paper) {
  return sheet.width_mm <= paper.width_mm && sheet.height_mm <= paper.height_mm;
}

// The smallest paper that takes the sheet; empty if none does.
std::string paper_for(const PrintedSheet& sheet) {
  for (const Paper& paper : kPapers)
    if (fits(sheet, paper) || fits(sheet, paper.landscape())) return std::string(paper.name);
  return "";
}

void print_true_to_scale(const BoardArguments& arguments, const std::string& kind,
                         const Board& board, std::vector<std::string>& warnings) {
  const std::string name = printable_name(arguments.target);
  const TagFamilies families = families_of(arguments, board);
  if (const double cell_mm = least_cell_mm(board, families); cell_mm < kLeastCell_mm)
    throw Error(
        fmt::format("{}: the smallest cells must be {} mm wide to be printed, got {:.3g} mm",
                    arguments.target, kLeastCell_mm, cell_mm));
  check_dpi(arguments, kind, board, families);
  const PrintedSheet sheet =
      naming(arguments.target, [&] { return board_sheet(board, families, name); });
  std::string where;
  if (!arguments.tile.empty()) {
    const Tiling tiling = tiling_on_pages(sheet, paper_named(arguments.tile));
    write_whole(arguments.out, tiled_pdf(sheet, tiling, name));
    where = fmt::format(" in {} page{} of {}", tiling.columns * tiling.rows,
                        tiling.columns * tiling.rows == 1 ? "" : "s", arguments.tile);
  } else {
    write_sheet(arguments, kind, sheet, name);
    const std::string paper = paper_for(sheet);
    if (!paper.empty()) where = ", fits " + paper;
    if (paper.empty())
      warnings.push_back(fmt::format(
          "{:.0f} x {:.0f} mm fit on no common paper: --paper a4 picks another size of the board, "
          "--tile a4 prints this one on several pages",
          sheet.width_mm, sheet.height_mm));
  }
  print_warnings(warnings);
  warnings.clear();
  say_wrote(arguments.out,
            fmt::format("{} on {:.0f} x {:.0f} mm{}; print at 100 % and check the bar of 100 mm",
                        size_text(board), sheet.width_mm, sheet.height_mm, where));
}

int run(const BoardArguments& arguments) {
  const std::string kind = fs::path(arguments.out).extension().string();
  check(arguments, kind);
  check_writable(arguments.out);
  check_replaces_nothing({arguments.out}, {arguments.target});
  std::vector<std::string> warnings;
  const Board board = board_to_print(arguments.target, &warnings);
  if (arguments.paper.empty())
    print_true_to_scale(arguments, kind, board, warnings);
  else
    print_on_paper(arguments, kind, board);
  print_warnings(warnings);
  return kAnswer;
}

}  // namespace

Command add_board(CLI::App& app) {
  CLI::App* command = add_command(app, "board", "a target to print, true to scale");
  const auto arguments = std::make_shared<BoardArguments>();
  add_option(*command, "TARGET.yaml", arguments->target, "the target").required();
  add_option(*command, "--out", arguments->out, "file to write: board.pdf, board.svg or board.png")
      .text("FILE")
      .required();
  add_positive(*command, "--dpi", arguments->dpi, "resolution of a PNG in pixels per inch (300)");
  const Option paper =
      add_option(
          *command, "--paper", arguments->paper,
          "the largest board on this paper: other sizes of tags, squares or discs; writes its "
          "target beside: board.yaml")
          .text("a4|a3|letter")
          .one_of({"a4", "a3", "letter"});
  add_flag(*command, "--landscape", arguments->landscape,
           "with --paper: landscape; otherwise what gives the larger board");
  add_option(*command, "--tile", arguments->tile,
             "true to scale over several pages of this paper, with marks to cut and join (PDF)")
      .text("a4|a3|letter")
      .one_of({"a4", "a3", "letter"})
      .excludes(paper);
  add_footer(*command,
             "Example: tagcal board target.yaml --out board.pdf\n"
             "         tagcal board target.yaml --out a4.pdf --paper a4");
  return {command, [arguments] { return run(*arguments); }, true};
}

}  // namespace tagcal::tools
