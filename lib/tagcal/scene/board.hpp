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
// upper-right, upper-left, on the upright tag), or point `tag_id` of a `points` target, of a
// checkerboard or of a grid of circles, with corner 0.
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

// A family of tags with the width of its black border in cells: 1 as generated, 2 as Kalibr prints.
struct TagKind {
  std::string family = "tag36h11";
  int border_bits = 1;
};

// Most tags or corners of one board, here and in files: memory for more is a mistake in the counts.
constexpr int kMaxBoardParts = 100'000;

// The kinds of boards. Lengths are metres. Unless a kind says otherwise, ids count row by row from
// below, and x points right, y up and z out of the board to the viewer.

// Measured points, each with corner 0.
struct Points {
  std::vector<TargetPoint> points;
};

// Single tags, rigid together, in the board's frame.
struct Tags {
  std::string family = "tag36h11";
  int border_bits = 1;
  std::vector<Tag> tags;
};

// Kalibr's AprilGrid. Origin: the outer lower-left corner of the lower-left tag.
struct AprilGrid {
  int columns = 0;
  int rows = 0;
  double tag_size = 0;
  double tag_spacing = 0;  // gap / tag_size
  int first_id = 0;
  std::string family = "tag36h11";
  int border_bits = 2;
  bool corner_squares = true;  // Kalibr's black squares between the tags
};

// A checkerboard; its corners, where four squares meet, are numbered, each with corner 0. Origin:
// the lower-left corner. A board with an odd number of squares in one direction and an even one in
// the other looks different turned by half a turn; any other looks the same.
struct Checkerboard {
  int columns = 0;  // of corners, one less than those of squares
  int rows = 0;
  double column_spacing = 0;  // along x
  double row_spacing = 0;     // along y
  bool starts_black = true;   // the square to the lower left of the first corner
  int first_id = 0;           // of the corners
};

// A ChArUco board: a checkerboard with markers in the middle of its white squares, upright,
// numbered row by row from above. The markers are found, but only the corners are observed.
struct Charuco {
  int square_columns = 0;
  int square_rows = 0;
  double square_size = 0;
  double marker_size = 0;       // outer black edge to outer black edge; less than a square
  std::string dictionary = {};  // a family of tags, for example "DICT_5X5_100"
  // The pattern of OpenCV before 4.6: the lower left square of the board is black; otherwise the
  // upper left one is. Both are the same for an odd number of rows of squares.
  bool legacy = false;
  int first_id = 0;         // of the corners
  int first_marker_id = 0;  // of the markers
};

// A grid of black discs on white, as OpenCV's and Kalibr's; a disc's centre is a point, with corner
// 0. Origin: the lower left of the grid, at a distance of `spacing` from the row above. In an
// asymmetric grid each row lies halfway between the discs of the next one: disc (column, row) is at
// ((2 column + (rows - 1 - row) mod 2) spacing, row spacing), so that the uppermost row is OpenCV's
// first. With an odd number of rows it looks different turned by half a turn; any other grid looks
// the same.
struct CircleGrid {
  int columns = 0;  // discs in a row
  int rows = 0;
  double spacing = 0;   // of rows, and of columns; in asymmetric rows discs are two spacings apart
  double diameter = 0;  // less than the least distance of two centres
  bool asymmetric = false;
  int first_id = 0;
};

using BoardPattern = std::variant<Points, Tags, AprilGrid, Checkerboard, Charuco, CircleGrid>;

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

// A calibration target. A default one has no points.
struct Board {
  BoardPattern pattern;
  Substrate substrate;
};

// The board of a pattern. Throws Error unless sizes and counts are positive (2 x 2 corners at
// least), the spacing of tags is not negative and markers are smaller than a square, and if there
// are more than kMaxBoardParts tags or corners or an id does not fit an int; and as
// check_substrate(). Points and single tags are taken as they are.
Board make_board(BoardPattern pattern, const Substrate& substrate = {});

// Corners 0..3 of a tag in the board frame.
std::array<Eigen::Vector3d, 4> tag_corners(const Tag& tag);

// The kinds of points that a board has.
enum class PointKind { measured, tag_corner, checker_corner, circle_centre };
PointKind point_kind(const Board& board);

// All points of the board that can be observed, in the board frame, ordered by id.
std::vector<TargetPoint> target_points(const Board& board);

// The tags of a board, or the markers of a ChArUco board, and their kind; no value without tags.
std::vector<Tag> tags_of(const Board& board);
std::optional<TagKind> tag_kind(const Board& board);

// The squares of a checkerboard or of a ChArUco board; no value for other boards.
std::optional<Checkerboard> checkers(const Board& board);

// Points in columns and rows; ids count row by row from below.
struct PointGrid {
  int columns = 0;
  int rows = 0;
  int first_id = 0;
};

// The grid of a board's points: of checkerboards, ChArUco boards and circles; no value for others.
std::optional<PointGrid> point_grid(const Board& board);

// The least distance between two centres of circles.
double centre_distance(const CircleGrid& grid);

}  // namespace tagcal
