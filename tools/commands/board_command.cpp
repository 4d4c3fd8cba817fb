#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "draw/sheet.hpp"
#include "input/arguments.hpp"
#include "input/input.hpp"
#include "report/messages.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "tagcal/scene/print/board_ink.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr double kMinMarginMm = 10;
constexpr double kMaxPixels = 100e6;
constexpr double kFlat_m = 1e-6;

struct Arguments {
  std::string target;
  std::string out;
  double dpi = 300;
};

Board board_to_print(const std::string& file, std::vector<std::string>* warnings) {
  Board board = read_target(file, {}, warnings);
  if (board.tags.empty()) throw Error(fmt::format("{}: no tags to print, only points", file));
  for (const Tag& tag : board.tags) {
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
  return board;
}

Sheet sheet_of(const Board& board, const TagFamily& family) {
  std::vector<Quad> ink;
  for (const Rectangle& cell : ink_cells(board, family)) {
    Quad quad;
    for (int i = 0; i < 4; ++i) quad[i] = 1000 * cell[i].head<2>();
    ink.push_back(quad);
  }
  double cell_mm = 0;  // a tag needs a white frame, at least one cell wide
  for (const Tag& tag : board.tags) {
    cell_mm = std::max(cell_mm, 1000 * tag.size / family.width_at_border);
  }
  return sheet_with_scale_bar(ink, std::max(kMinMarginMm, 2 * cell_mm));
}

Image8 picture_of(const Sheet& sheet, double dpi) {
  const ImageSize size = sheet_size(sheet, dpi / 25.4);
  if (static_cast<double>(size.width) * size.height > kMaxPixels) {
    throw Error(
        fmt::format("--dpi: the picture must have {:.0f} megapixels at most, got {}x{} at {:g}",
                    kMaxPixels / 1e6, size.width, size.height, dpi));
  }
  return sheet_image(sheet, dpi / 25.4);
}

int run(const Arguments& arguments) {
  const std::string kind = fs::path(arguments.out).extension().string();
  if (kind != ".svg" && kind != ".png") {
    throw Error(fmt::format("--out: must end in .svg or .png, got {}", arguments.out));
  }
  check_writable(arguments.out);
  std::vector<std::string> warnings;
  const Board board = board_to_print(arguments.target, &warnings);
  const Sheet sheet = sheet_of(board, tag_family(board.family, board.border_bits));
  if (kind == ".svg") {
    write_whole(arguments.out, sheet_svg(sheet, fs::path(arguments.target).filename().string()));
  } else {
    write_png(arguments.out, picture_of(sheet, arguments.dpi), arguments.dpi);
  }
  print_warnings(warnings);
  print_to_stderr("{}: {} tags on {:.0f} x {:.0f} mm; print at 100 % and check the bar of 100 mm\n",
                  arguments.out, board.tags.size(), sheet.width_mm, sheet.height_mm);
  return kAnswer;
}

}  // namespace

Command add_board(CLI::App& app) {
  CLI::App* command = add_command(app, "board", "a target to print, true to scale");
  const auto arguments = std::make_shared<Arguments>();
  add_option(*command, "TARGET.yaml", arguments->target, "the target").text(" ").required();
  add_option(*command, "--out", arguments->out, "file to write: board.svg or board.png")
      .text("FILE REQUIRED")
      .required();
  add_positive(*command, "--dpi", arguments->dpi, "resolution of a PNG in pixels per inch (300)");
  add_footer(*command, "Example: tagcal board target.yaml --out board.svg");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
