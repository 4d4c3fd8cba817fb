#include "draw/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "tagcal/scene/raster/coverage.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr int kCapPieces = 8;
constexpr int kBandRows = 64;
constexpr double kSamePoint_px = 1e-3;

// The parts of a line inside the window.
std::vector<Polyline> clipped(const Polyline& line, const Window& window) {
  std::vector<Polyline> parts;
  bool broken = true;
  const auto add = [&](const Vector2d& from, const Vector2d& to) {
    const std::optional<Segment2> inside = clip_line_liang_barsky(window, {from, to});
    if (inside) {
      if (broken || inside->from != from) parts.push_back({inside->from});
      parts.back().push_back(inside->to);
    }
    broken = !inside || inside->to != to;
  };
  if (line.size() == 1) add(line[0], line[0]);
  for (std::size_t i = 1; i < line.size(); ++i) add(line[i - 1], line[i]);
  return parts;
}

std::vector<Polyline> dashes(const Polyline& line, double dash_px) {
  std::vector<Polyline> parts = {{line.front()}};
  double left = dash_px;
  bool drawn = true;
  for (std::size_t i = 1; i < line.size(); ++i) {
    Vector2d from = line[i - 1];
    double length = (line[i] - from).norm();
    while (length > left) {
      from += left / length * (line[i] - from);
      length -= left;
      if (drawn) parts.back().push_back(from);
      drawn = !drawn;
      if (drawn) parts.push_back({from});
      left = dash_px;
    }
    left -= length;
    if (drawn) parts.back().push_back(line[i]);
  }
  return parts;
}

Polyline without_repeated_points(const Polyline& line) {
  Polyline result = {line.front()};
  for (const Vector2d& p : line)
    if ((p - result.back()).norm() > kSamePoint_px) result.push_back(p);
  return result;
}

Vector2d normal(const Vector2d& from, const Vector2d& to) {
  const Vector2d along = (to - from).normalized();
  return {-along.y(), along.x()};
}

// Offset from the line's middle to its border at point i: across the line, longer at a bend.
Vector2d across(const Polyline& line, std::size_t i) {
  if (i == 0) return normal(line[0], line[1]);
  const Vector2d before = normal(line[i - 1], line[i]);
  if (i + 1 == line.size()) return before;
  const Vector2d after = normal(line[i], line[i + 1]);
  const double cosine = before.dot(after);
  if (cosine < 0) return after;  // a sharp turn: no spike
  return (before + after) / (1 + cosine);
}

// Half a circle around an end of the line, beginning at `start`.
void add_cap(Polyline& outline, const Vector2d& centre, const Vector2d& start) {
  for (int i = 0; i <= kCapPieces; ++i) {
    const double angle = -std::numbers::pi * i / kCapPieces;
    const double c = std::cos(angle), s = std::sin(angle);
    outline.push_back(centre +
                      Vector2d(c * start.x() - s * start.y(), s * start.x() + c * start.y()));
  }
}

// The outline of the area that a round pen covers, in the raster's coordinates, which begin half a
// pixel before the pixel's centre.
Polyline outline_of(const Polyline& stroke, double width_px) {
  const Polyline line = without_repeated_points(stroke);
  const double half = width_px / 2;
  Polyline outline;
  if (line.size() == 1) {
    add_cap(outline, line[0], {half, 0});
    add_cap(outline, line[0], {-half, 0});
  } else {
    for (std::size_t i = 0; i < line.size(); ++i)
      outline.push_back(line[i] + half * across(line, i));
    add_cap(outline, line.back(), half * across(line, line.size() - 1));
    for (std::size_t i = line.size(); i-- > 0;) outline.push_back(line[i] - half * across(line, i));
    add_cap(outline, line.front(), -half * across(line, 0));
  }
  for (Vector2d& p : outline) p.array() += 0.5;
  return outline;
}

void blend(Rgb& below, const Rgb& colour, double share) {
  for (std::size_t i = 0; i < colour.size(); ++i)
    below[i] = static_cast<std::uint8_t>(std::lround(below[i] + share * (colour[i] - below[i])));
}

}  // namespace

Canvas::Canvas(const Image8& picture) : image_(picture.size()) {
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) image_(x, y).fill(picture(x, y));
}

Canvas::Canvas(const ImageSize& size, const Rgb& colour) : image_(size, colour) {}

void Canvas::draw(const std::vector<Polyline>& lines, const Pen& pen) {
  const double margin = 2 * pen.width_px + 1;
  const Window window{-margin, image_.width() + margin, -margin, image_.height() + margin};
  Outlines outlines;
  for (const Polyline& line : lines)
    for (const Polyline& part : clipped(line, window))
      for (const Polyline& stroke :
           pen.dash_px > 0 ? dashes(part, pen.dash_px) : std::vector<Polyline>{part})
        outlines.add(outline_of(stroke, pen.width_px));
  for (int row = 0; row < image_.height(); row += kBandRows) {
    CoverageBand band(image_.width(), std::min(kBandRows, image_.height() - row));
    band.move_to(row);
    band.accumulate(outlines.edges());
    band.drain([&](int r, int first, int last, float share) {
      for (int x = first; x < last; ++x)
        blend(image_(x, row + r), pen.colour, pen.opacity * std::min(1.0F, std::abs(share)));
    });
  }
}

Polyline circle(const Vector2d& centre, double radius_px) {
  constexpr int kPieces = 32;
  Polyline line;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPieces;
    line.push_back(centre + radius_px * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return line;
}

}  // namespace tagcal::tools
