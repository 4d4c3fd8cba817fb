#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal::internal {

// A set of closed outlines in the image, as straight edges; coordinates in cells of the raster,
// cell i spans [i, i + 1).
class Outlines {
 public:
  struct Edge {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
  };

  // Adds a closed polygon, oriented so that its area is positive.
  void add(const std::vector<Eigen::Vector2d>& polygon);

  const std::vector<Edge>& edges() const { return edges_; }

  // Takes every point x to scale * x + offset.
  void transform(double scale, const Eigen::Vector2d& offset) {
    for (Edge& edge : edges_) edge = {scale * edge.from + offset, scale * edge.to + offset};
  }

 private:
  std::vector<Edge> edges_;
};

// The share of every cell that outlines cover, exact but for rounding: each edge adds the signed
// area between it and the right border of its row, and a running sum along the row does the rest
// (as font rasterisers do: Levien, font-rs). Disjoint polygons add up, shared edges cancel. Only
// blocks of cells that an edge passes cost work cell by cell.
class CoverageBand {
 public:
  static constexpr int kBlock = 4;  // cells for which one bit says whether an edge passes any

  // Rows [first_row, first_row + num_rows) of a raster of `width` cells, from 0 at first.
  CoverageBand(int width, int num_rows);

  // Moves to other rows; the band must be empty.
  void move_to(int first_row) {
    first_row_ = first_row;
    std::ranges::fill(passed_, 0);
  }

  void accumulate(std::span<const Outlines::Edge> edges);

  // Calls visit(row, first, last, share) for runs [first, last) of cells with the same share, where
  // there is any; rows count from first_row. Empties the band.
  template <typename Visit>
  void drain(Visit&& visit) {
    for (int r = 0; r < num_rows_; ++r) {
      double share = 0;  // as a float, this sum would drift by 1e-5 along a row
      int done = 0;      // cells
      for (int word = 0; word < words_; ++word) {
        std::uint64_t& touched = touched_[static_cast<std::size_t>(r * words_ + word)];
        passed_[static_cast<std::size_t>(r * words_ + word)] |= touched;
        for (; touched != 0; touched &= touched - 1) {
          const int first = kBlock * (64 * word + std::countr_zero(touched));
          visit_flat(visit, r, done, std::min(first, width_), share);
          done = std::min(first + kBlock, width_);
          float* cells = row(r);
          for (int c = first; c < done; ++c) {
            share += static_cast<double>(std::exchange(cells[c], 0.0f));
            visit(r, c, c + 1, rounded(share));
          }
        }
      }
      visit_flat(visit, r, done, width_, share);
    }
  }

  // The blocks of row r that were drained since the last move, one bit each.
  std::span<const std::uint64_t> passed(int r) const {
    return std::span(passed_).subspan(static_cast<std::size_t>(r * words_),
                                      static_cast<std::size_t>(words_));
  }

 private:
  static constexpr double kRounding = 5e-7;  // closer shares are rounded to 0 or 1

  // Snapping gives a uniform area one level, which 8-bit rounding would otherwise split at a half.
  static float rounded(double share) {
    if (std::abs(share) < kRounding) return 0;
    if (std::abs(share - 1) < kRounding) return 1;
    return static_cast<float>(share);
  }

  // Cells [first, last), in which no edge passes.
  template <typename Visit>
  static void visit_flat(Visit& visit, int r, int first, int last, double share) {
    if (rounded(share) != 0 && first < last) visit(r, first, last, rounded(share));
  }

  float* row(int r) { return cells_.data() + static_cast<std::size_t>(r) * stride_; }
  void add_edge(Eigen::Vector2d from, Eigen::Vector2d to);
  void add_in_row(int r, Eigen::Vector2d from, Eigen::Vector2d to, double sign);
  void add_inside(int r, double x0, double x1, double area);

  int width_;
  int first_row_ = 0;
  int num_rows_;
  int words_;           // of touched_, a row
  std::size_t stride_;  // of cells_
  std::vector<float> cells_;
  std::vector<std::uint64_t> touched_;  // not drained yet
  std::vector<std::uint64_t> passed_;   // drained since the last move
};

}  // namespace tagcal::internal
