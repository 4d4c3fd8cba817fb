#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect: a known tag's cells compared with a picture.
namespace tagcal::internal {

// The surroundings of a tag on its board.
struct CellSurroundings {
  bool white_frame = true;      // a ring of white cells around a black border
  bool corner_squares = false;  // they cover that ring's corners
};

// The expected colours of a tag's cells. Cells are counted from the border's upper-left one, x
// right, y down on the upright tag.
class TagCells {
 public:
  enum class Part { bit, fixed, unknown };  // fixed: of the border or the frame
  struct Cell {
    bool white = false;
    Part part = Part::unknown;
  };

  // Precondition: the family has the id.
  TagCells(const TagFamily& family, int id, const CellSurroundings& surroundings);

  int width() const { return width_; }                  // cells of the whole pattern along a side
  int width_at_border() const { return border_; }       // cells between the corners
  int start() const { return (width_ - border_) / 2; }  // index of the border's first cell
  const Cell& cell(int x, int y) const { return cells_[static_cast<std::size_t>(y * width_ + x)]; }

 private:
  Cell& at(int x, int y) { return cells_[static_cast<std::size_t>(y * width_ + x)]; }

  int width_;
  int border_;
  std::vector<Cell> cells_;
};

// The comparison of a pattern with a picture.
struct TagAnswer {
  double contrast = 0;     // grey levels from black to white at the centre
  int wrong_bits = 0;      // in the payload
  double wrong_fixed = 1;  // share of the cells of border and frame
};

// Compares every cell, sharpened against the blur between neighbours, with the mean of black and
// white, each a plane of levels fitted to the fixed cells (as AprilTag does: Olson, ICRA 2011).
TagAnswer read_tag(const ImageView8& image, const Quad& quad, const TagCells& pattern);

// Correlation of a pattern and the picture under it, in [-1, 1]; 0 if the picture is flat.
double pattern_correlation(const ImageView8& image, const Quad& quad, const TagCells& pattern);

// Moves a quad to the highest correlation: as a whole by up to `reach` cells, then corner by
// corner by steps down to a fifth of a pixel, and not below a last one.
Quad best_correlated_quad(const ImageView8& image, const Quad& start, const TagCells& pattern,
                          double reach, double last_step_cells = 0);

}  // namespace tagcal::internal
