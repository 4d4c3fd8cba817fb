#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
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

// Identifies a point that can be observed: corner 0..3 of a tag (lower-left, lower-right,
// upper-right, upper-left, on the upright tag), or point `tag_id` of a `points` target, with corner
// 0.
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

// A calibration target: tags, or measured points.
struct Board {
  std::string family = "tag36h11";
  int border_bits = 2;  // width of the black border in cells: 2 as Kalibr prints, 1 for plain tags
  bool corner_squares = true;  // Kalibr's black squares between the tags
  std::optional<Grid> grid;    // set if the tags form a grid
  std::vector<Tag> tags;
  std::vector<TargetPoint> points;  // of a `points` target; then there are no tags
};

// The board of a grid. Throws Error unless the sizes are positive and the spacing is not negative.
Board grid_board(const Grid& grid, std::string family = "tag36h11", int border_bits = 2,
                 bool corner_squares = true);

// Corners 0..3 of a tag in the board frame.
std::array<Eigen::Vector3d, 4> tag_corners(const Tag& tag);

// All points of the board that can be observed, in the board frame, ordered by id.
std::vector<TargetPoint> target_points(const Board& board);

}  // namespace tagcal
