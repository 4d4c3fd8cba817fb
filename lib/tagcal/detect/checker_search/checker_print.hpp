#pragma once

#include <map>
#include <utility>
#include <vector>

#include "tagcal/detect/refine.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// A corner of a checkerboard (column, row), or a square: (0, 0) is the one to the lower left of the
// first corner.
using CheckerCell = std::pair<int, int>;

// The print of a checkerboard, with the markers of a ChArUco board.
class CheckerPrint {
 public:
  // Precondition: the board has squares. Throws Error as tag_family() does.
  explicit CheckerPrint(const Board& board);

  int columns() const { return columns_; }  // of corners
  int rows() const { return rows_; }
  bool starts_black() const { return starts_black_; }
  void set_starts_black(bool value) { starts_black_ = value; }
  bool is_at_edge(const CheckerCell& corner) const;

  // The print about a corner; unit: squares; x right, y up. `outside` is the part of the outermost
  // squares that is known.
  CornerPattern about(const CheckerCell& corner, double outside) const;

 private:
  std::vector<double> lines(int corner, int count, double outside) const;
  TagPattern::Cell colour(double x, double y) const;

  int columns_ = 0, rows_ = 0;
  bool starts_black_ = true;
  int marker_cells_ = 0;                                          // along a side of a marker
  double marker_side_ = 0;                                        // squares
  std::map<CheckerCell, std::vector<TagPattern::Cell>> markers_;  // by square, rows from above
};

}  // namespace tagcal::internal
