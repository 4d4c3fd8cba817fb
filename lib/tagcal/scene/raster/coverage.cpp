#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// Edges with a smaller change of y are ignored: their area is below rounding.
constexpr double kFlat = 1e-10;

double signed_area(const std::vector<Vector2d>& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d a = polygon[i] - polygon[0];
    const Vector2d b = polygon[(i + 1) % polygon.size()] - polygon[0];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum / 2;
}

}  // namespace

void Outlines::add(const std::vector<Vector2d>& polygon) {
  // A downward edge has its area on its right, which is a negative shoelace area in image axes.
  const bool reverse = signed_area(polygon) > 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    edges_.push_back(reverse ? Edge{b, a} : Edge{a, b});
  }
}

// A row has extra cells for the terms that an edge at the right border adds beyond it; they are not
// read.
CoverageBand::CoverageBand(int width, int num_rows)
    : width_(width),
      num_rows_(num_rows),
      words_((width + 2 + 64 * kBlock - 1) / (64 * kBlock)),
      stride_(static_cast<std::size_t>(width) + 2),
      cells_(static_cast<std::size_t>(num_rows) * stride_),
      touched_(static_cast<std::size_t>(num_rows * words_)),
      passed_(touched_.size()) {}

void CoverageBand::accumulate(std::span<const Outlines::Edge> edges) {
  const double top = first_row_, bottom = first_row_ + num_rows_;
  for (const Outlines::Edge& edge : edges) {
    if (std::min(edge.from.y(), edge.to.y()) >= bottom) continue;
    if (std::max(edge.from.y(), edge.to.y()) <= top) continue;
    add_edge(edge.from, edge.to);
  }
}

void CoverageBand::add_edge(Vector2d from, Vector2d to) {
  if (std::abs(from.y() - to.y()) < kFlat) return;
  if (std::min(from.x(), to.x()) >= width_) return;
  const double sign = from.y() < to.y() ? 1 : -1;
  if (sign < 0) std::swap(from, to);
  const double end = std::min(to.y(), static_cast<double>(first_row_ + num_rows_));
  const double slope = (to.x() - from.x()) / (to.y() - from.y());
  const double left = std::min(from.x(), to.x()), right = std::max(from.x(), to.x());
  const bool inside = left >= 0 && right <= width_;
  const auto x_at = [&](double y) {
    return std::clamp(from.x() + (y - from.y()) * slope, left, right);
  };
  double y = std::max(from.y(), static_cast<double>(first_row_)), x = x_at(y);
  for (int r = static_cast<int>(y) - first_row_; y < end; ++r) {
    const double next = std::min(end, first_row_ + r + 1.0), next_x = x_at(next);
    if (inside)
      add_inside(r, x, next_x, sign * (next - y));
    else
      add_in_row(r, {x, y}, {next_x, next}, sign);
    y = next;
    x = next_x;
  }
}

// Adds an edge within one row. Parts left of the raster count at its left border, parts right of it
// do not count.
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

// Distributes over the cells the area `area` (of the row's height) that begins between x0 and x1.
void CoverageBand::add_inside(int r, double x0, double x1, double area) {
  if (x0 > x1) std::swap(x0, x1);
  const int first = static_cast<int>(x0);
  const int end = static_cast<int>(x1);
  const int last = std::max(first, x1 > end ? end : end - 1);  // the cell that x1 ends in
  for (int block = first / kBlock; block <= (last + 1) / kBlock; ++block)
    touched_[static_cast<std::size_t>(r * words_ + block / 64)] |= std::uint64_t{1} << block % 64;
  float* cells = row(r);
  if (first == last) {
    const double share = 1 - ((x0 + x1) / 2 - first);
    cells[first] += static_cast<float>(area * share);
    cells[first + 1] += static_cast<float>(area * (1 - share));
    return;
  }
  // Covered share of each cell, the mean over it of (x - x0) / (x1 - x0), clamped to [0, 1];
  // differences of which go into the running sum.
  const double half = 1 / (2 * (x1 - x0));
  double before = 0;
  for (int c = first; c <= last; ++c) {
    const double low = std::max(x0, static_cast<double>(c)) - x0;
    const double high = std::min(x1, c + 1.0) - x0;
    const double beyond = std::max(0.0, c + 1.0 - x1);
    const double share = (high * high - low * low) * half + beyond;
    cells[c] += static_cast<float>(area * (share - before));
    before = share;
  }
  cells[last + 1] += static_cast<float>(area * (1 - before));
}

}  // namespace tagcal::internal
