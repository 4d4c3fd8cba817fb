#include "tagcal/scene/coverage.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal {
namespace {

using Eigen::Vector2d;

double signed_area(const std::vector<Vector2d>& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d a = polygon[i] - polygon[0];
    const Vector2d b = polygon[(i + 1) % polygon.size()] - polygon[0];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum / 2;
}

double x_at(const Vector2d& a, const Vector2d& b, double y) {
  return a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

}  // namespace

void Outlines::add(const std::vector<Vector2d>& polygon) {
  // An edge that runs down has its area on its right: negative area by the shoelace in image axes.
  const bool reverse = signed_area(polygon) > 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    edges_.push_back(reverse ? Edge{b, a} : Edge{a, b});
  }
}

CoverageBand::CoverageBand(int width, int first_row, int num_rows)
    : width_(width),
      first_row_(first_row),
      num_rows_(num_rows),
      cells_(static_cast<std::size_t>(num_rows) * static_cast<std::size_t>(width + 2)),
      touched_(static_cast<std::size_t>(num_rows)) {}

void CoverageBand::accumulate(const Outlines& outlines) {
  const double top = first_row_, bottom = first_row_ + num_rows_;
  for (const Outlines::Edge& edge : outlines.edges()) {
    if (std::min(edge.from.y(), edge.to.y()) >= bottom) continue;
    if (std::max(edge.from.y(), edge.to.y()) <= top) continue;
    add_edge(edge.from, edge.to);
  }
}

void CoverageBand::add_edge(Vector2d from, Vector2d to) {
  if (from.y() == to.y()) return;
  const double sign = from.y() < to.y() ? 1 : -1;
  if (sign < 0) std::swap(from, to);
  const double begin = std::max(from.y(), static_cast<double>(first_row_));
  const double end = std::min(to.y(), static_cast<double>(first_row_ + num_rows_));
  double y = begin;
  while (y < end) {
    const double next = std::min(end, std::floor(y) + 1);
    const int r = static_cast<int>(std::floor(y)) - first_row_;
    add_in_row(r, {x_at(from, to, y), y}, {x_at(from, to, next), next}, sign);
    y = next;
  }
}

// An edge within one row; parts left of the raster count as its border, parts right of it as none.
void CoverageBand::add_in_row(int r, Vector2d from, Vector2d to, double sign) {
  for (const double border : {0.0, static_cast<double>(width_)}) {
    if ((from.x() < border) == (to.x() < border) || from.x() == border || to.x() == border)
      continue;
    const double y = from.y() + (border - from.x()) / (to.x() - from.x()) * (to.y() - from.y());
    add_in_row(r, from, {border, y}, sign);
    add_in_row(r, {border, y}, to, sign);
    return;
  }
  const double limit = width_;
  add_inside(r, std::clamp(from.x(), 0.0, limit), std::clamp(to.x(), 0.0, limit),
             sign * (to.y() - from.y()));
}

// The area `area` (of the row's height) that begins between x0 and x1, spread over the cells.
void CoverageBand::add_inside(int r, double x0, double x1, double area) {
  if (x0 > x1) std::swap(x0, x1);
  const int first = static_cast<int>(std::floor(x0));
  const int last = std::max(first, static_cast<int>(std::ceil(x1)) - 1);  // cell that x1 ends in
  Touched& touched = touched_[static_cast<std::size_t>(r)];
  touched.first = std::min(touched.first, first);
  touched.last = std::max(touched.last, last + 1);
  float* cells = row(r);
  // Covered share of each cell, differences of which go into the running sum.
  double before = 0;
  for (int c = first; c <= last; ++c) {
    double share;
    if (first == last) {
      share = 1 - ((x0 + x1) / 2 - c);
    } else {
      // The mean over the cell of (x - x0) / (x1 - x0), clamped to [0, 1].
      const double low = std::max(x0, static_cast<double>(c)) - x0;
      const double high = std::min(x1, c + 1.0) - x0;
      const double beyond = std::max(0.0, c + 1.0 - x1);
      share = (high * high - low * low) / (2 * (x1 - x0)) + beyond;
    }
    cells[c] += static_cast<float>(area * (share - before));
    before = share;
  }
  cells[last + 1] += static_cast<float>(area * (1 - before));
}

}  // namespace tagcal
