#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tagcal/geometry/pose.hpp"

namespace tagcal {

// The patterns of an AprilTag family as plain data; tagcal/detect/families.hpp reads them from the
// AprilTag library. Cells are counted from the upper-left cell of the whole printed tag, x right,
// y down; total_width counts all cells, including the white (or, for a reversed border, black)
// frame.
struct TagFamily {
  struct Cell {
    int x = 0;
    int y = 0;
  };

  std::string name;
  int width_at_border = 0;  // cells between the corners that the detector reports
  int total_width = 0;      // cells of the whole pattern
  bool reversed_border = false;
  std::vector<Cell> bits;            // cell of each bit relative to the border's upper-left cell
  std::vector<std::uint64_t> codes;  // per id, bits.front() is the most significant
};

using TagFamilies = std::map<std::string, TagFamily>;  // by name

// Identifies a point that can be observed: corner 0..3 of a tag (lower-left, lower-right,
// upper-right, upper-left, on the upright tag), or point `tag_id` of a `points` target or of a
// checkerboard, with corner 0.
struct CornerId {
  int tag_id = 0;
  int corner = 0;
  auto operator<=>(const CornerId&) const = default;
};

struct TargetPoint {
  CornerId id;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // metres
};

// One tag. Tag frame: origin at the tag's centre, x right, y up, z out of the tag to the viewer.
// The corners are at (+-size/2, +-size/2, 0).
struct Tag {
  int id = 0;
  double size = 0;  // metres, outer black edge to outer black edge
  Pose board_from_tag;
};

// Most tags or corners of one board, here and in files: memory for more is a mistake in the counts.
constexpr int kMaxBoardParts = 100'000;

// Kalibr's AprilGrid: tag ids row by row from below, first_id at the lower left. Board frame:
// origin at the outer lower-left corner of that tag, x right, y up, z out of the board to the
// viewer.
struct Grid {
  int columns = 0;
  int rows = 0;
  double tag_size = 0;     // metres
  double tag_spacing = 0;  // gap / tag_size
  int first_id = 0;
};

// The corners of a checkerboard, where four squares meet: row by row from below, first_id at the
// lower left, each with corner 0. Board frame: origin at that corner, x right, y up, z out of the
// board to the viewer. A board with an odd number of squares in one direction and an even one in
// the other looks different turned by half a turn; any other looks the same.
struct Checkerboard {
  int columns = 0;  // of corners, one less than those of squares
  int rows = 0;
  double column_spacing = 0;  // metres, along x
  double row_spacing = 0;     // metres, along y
  bool starts_black = true;   // the square to the lower left of the first corner
  int first_id = 0;           // of the corners
};

// The markers of a ChArUco board, in the middle of its white squares, upright, row by row from
// above.
struct CharucoMarkers {
  double size = 0;              // metres, outer black edge to outer black edge; less than a square
  std::string dictionary = {};  // a family of tags, for example "DICT_5X5_100"
  // The pattern of OpenCV before 4.6: the lower left square of the board is black; otherwise the
  // upper left one is. Both are the same for an odd number of rows of squares.
  bool legacy = false;
  int first_marker_id = 0;
};

enum class Material { paper, aluminium, glass };

std::string_view material_name(Material material);
std::optional<Material> material_named(std::string_view name);

// A standard deviation before any picture: as is usual for a material, or a share, which is > 0 and
// at most kMaxTolerance.
using Tolerance = std::variant<Material, double>;
constexpr double kMaxTolerance = 0.1;  // more is a mistake in the file

// The material of a board tells how far it may differ from its file.
struct Substrate {
  Tolerance flatness = Material::paper;  // its bends and twist, over its diagonal
  Tolerance print = Material::paper;     // the share by which it is longer along y than along x
  bool operator==(const Substrate&) const = default;
};

// Throws Error for a share out of its range.
void check_substrate(const Substrate& substrate);

// A calibration target: tags, a checkerboard with or without markers, or measured points.
struct Board {
  std::string family = "tag36h11";
  int border_bits = 2;  // width of the black border in cells: 2 as Kalibr prints, 1 for plain tags
  bool corner_squares = true;  // Kalibr's black squares between the tags
  std::optional<Grid> grid;    // set if the tags form a grid
  std::optional<Checkerboard> checkerboard;
  std::optional<CharucoMarkers> charuco;  // only with a checkerboard
  // Of a ChArUco board the markers; their corners are found, but not observed (target_points).
  std::vector<Tag> tags;
  std::vector<TargetPoint> points;  // of a `points` target or a checkerboard
  Substrate substrate;
};

// The board of a grid. Throws Error unless the sizes are positive and the spacing is not negative,
// and if there are more than kMaxBoardParts tags or the ids do not fit an int.
Board grid_board(const Grid& grid, std::string family = "tag36h11", int border_bits = 2,
                 bool corner_squares = true);

// A checkerboard. Throws Error unless there are 2 x 2 corners or more, kMaxBoardParts at most, and
// the spacings are positive, and if the ids do not fit an int.
Board checkerboard_board(const Checkerboard& checkerboard);

// A ChArUco board with square squares; `checkerboard.starts_black` is set by the layout. Throws
// Error as checkerboard_board, for spacings that differ, and for markers that do not fit into a
// square.
Board charuco_board(const Checkerboard& checkerboard, const CharucoMarkers& markers);

// Corners 0..3 of a tag in the board frame.
std::array<Eigen::Vector3d, 4> tag_corners(const Tag& tag);

// All points of the board that can be observed, in the board frame, ordered by id.
std::vector<TargetPoint> target_points(const Board& board);

}  // namespace tagcal
