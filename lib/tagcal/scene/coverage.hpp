#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

// A set of closed outlines in the image, as straight edges; coordinates in cells of the raster,
// cell i spans [i, i + 1).
class Outlines {
 public:
  struct Edge {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
  };

  // A closed polygon, turned so that it counts as positive area whichever way it runs.
  void add(const std::vector<Eigen::Vector2d>& polygon);

  const std::vector<Edge>& edges() const { return edges_; }

 private:
  std::vector<Edge> edges_;
};

// The share of every cell that outlines cover, exact but for rounding: each edge adds the signed
// area between it and the right border of its row, and a running sum along the row does the rest
// (as font rasterisers do: Levien, font-rs). Disjoint polygons add up, shared edges cancel.
class CoverageBand {
 public:
  // Rows [first_row, first_row + num_rows) of a raster of `width` cells.
  CoverageBand(int width, int first_row, int num_rows);

  void accumulate(const Outlines& outlines);

  // Calls visit(row, column, share) for every cell with a share; rows count from first_row. Empties
  // the band.
  template <typename Visit>
  void drain(Visit&& visit) {
    for (int r = 0; r < num_rows_; ++r) {
      float* cells = row(r);
      float share = 0;
      const Touched touched = touched_[static_cast<std::size_t>(r)];
      for (int c = touched.first; c <= touched.last; ++c) {
        share += cells[c];
        cells[c] = 0;
        if (c < width_) visit(r, c, share);
      }
      touched_[static_cast<std::size_t>(r)] = {};
    }
  }

 private:
  struct Touched {
    int first = 1 << 30;
    int last = -1;
  };

  float* row(int r) { return cells_.data() + static_cast<std::size_t>(r) * (width_ + 2); }
  void add_edge(Eigen::Vector2d from, Eigen::Vector2d to);
  void add_in_row(int r, Eigen::Vector2d from, Eigen::Vector2d to, double sign);
  void add_inside(int r, double x0, double x1, double area);

  int width_;
  int first_row_;
  int num_rows_;
  std::vector<float> cells_;
  std::vector<Touched> touched_;
};

}  // namespace tagcal
