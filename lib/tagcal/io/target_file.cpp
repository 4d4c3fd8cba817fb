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

// Warns of a printed board that is wider than any: its lengths may be millimetres.
void warn_of_wide(const Board& board, const std::filesystem::path& file,
                  std::vector<std::string>& warnings) {
  if (!point_grid(board) && !std::holds_alternative<AprilGrid>(board.pattern)) return;
  Eigen::AlignedBox3d box;
  for (const TargetPoint& point : target_points(board)) box.extend(point.position);
  const double side = box.sizes().maxCoeff();
  if (side <= kWidestBoardM) return;
  warnings.push_back(
      fmt::format("{}: the board is {:.3g} m wide: lengths are in metres; write 30mm or 0.03 for "
                  "30 millimetres",
                  file.string(), side));
}

}  // namespace

Board read_target(const std::filesystem::path& file, std::optional<int> first_id,
                  std::vector<std::string>* warnings, std::optional<double> tag_size_m) {
  Board board = board_from_yaml(YamlValue::read(file), first_id, warnings, tag_size_m);
  if (warnings) warn_of_wide(board, file, *warnings);
  return board;
}

std::string target_yaml(const Board& board) { return board_yaml(board); }

void write_target(const std::filesystem::path& file, const Board& board) {
  write_whole(file, target_yaml(board));
}

}  // namespace tagcal
