#include "tagcal/io/target_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <variant>

#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_boards.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr double kWidestBoardM = 5;  // chosen by hand: no board is printed wider

void add_warning(const std::optional<std::string>& warning, std::vector<std::string>& warnings) {
  if (warning) warnings.push_back(*warning);
}

// Warns of a printed board that is wider than any: its lengths may be millimetres.
void warn_of_wide(const Board& board, const std::filesystem::path& file,
                  std::vector<std::string>& warnings) {
  if (!point_grid(board) && !std::holds_alternative<AprilGrid>(board.pattern)) return;
  Eigen::AlignedBox3d box;
  for (const TargetPoint& point : target_points(board)) box.extend(point.position);
  add_warning(wide_warning(file.string() + ": the board", box.sizes().maxCoeff()), warnings);
}

}  // namespace

std::optional<std::string> wide_warning(std::string_view what, double width_m) {
  if (width_m <= kWidestBoardM) return std::nullopt;
  return fmt::format(
      "{} is {:.3g} m wide: lengths are in metres; write 30mm or 0.03 for 30 millimetres", what,
      width_m);
}

Board read_target(const std::filesystem::path& file, std::optional<int> first_id,
                  std::vector<std::string>* warnings, std::optional<double> tag_size_m) {
  Board board = board_from_yaml(YamlValue::read(file), first_id, warnings, tag_size_m);
  if (warnings) warn_of_wide(board, file, *warnings);
  if (warnings && tag_size_m)
    add_warning(wide_warning(file.string() + ": a tag", *tag_size_m), *warnings);
  return board;
}

std::string target_yaml(const Board& board) { return board_yaml(board); }

void write_target(const std::filesystem::path& file, const Board& board) {
  write_whole(file, target_yaml(board));
}

}  // namespace tagcal
