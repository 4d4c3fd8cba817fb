#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/detect/tag_fit/refine_edges.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect: a known tag held against a picture.
namespace tagcal::internal {

// What lies about a tag on its board, as far as its pattern does not say it.
struct CellSurroundings {
  bool white_frame = true;      // a ring of white cells around a black border
  bool corner_squares = false;  // which hide that ring's corners
};

// What the cells of one tag should look like. Cells are counted from the border's upper-left one,
// x right, y down on the upright tag.
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
  int width_at_border() const { return border_; }       // and between the corners
  int start() const { return (width_ - border_) / 2; }  // place of the border's first cell
  const Cell& cell(int x, int y) const { return cells_[static_cast<std::size_t>(y * width_ + x)]; }

 private:
  Cell& at(int x, int y) { return cells_[static_cast<std::size_t>(y * width_ + x)]; }

  int width_;
  int border_;
  std::vector<Cell> cells_;
};

// What the picture answers to a pattern laid over it.
struct TagAnswer {
  double contrast = 0;     // grey levels from black to white, by the fixed cells
  int wrong_bits = 0;      // of the payload
  double wrong_fixed = 1;  // share of the cells of border and frame
};

// Reads every cell against the mean of black and white, each a plane over the tag, fitted to the
// fixed cells (as AprilTag does: Olson, ICRA 2011), after the light that neighbouring cells lend
// each other is taken off again.
TagAnswer read_tag(const Image8& image, const Quad& quad, const TagCells& pattern);

// The correlation of a pattern and the picture under it, in [-1, 1]; 0 where the picture is flat.
double likeness(const Image8& image, const Quad& quad, const TagCells& pattern);

// Moves a quad, first as a whole by up to `reach` cells, then corner by corner, to where the
// picture is most like the pattern.
Quad settle(const Image8& image, const Quad& start, const TagCells& pattern, double reach);

}  // namespace tagcal::internal
