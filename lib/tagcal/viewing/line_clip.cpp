#include "tagcal/viewing/clip.hpp"

#include <algorithm>
#include <utility>

namespace tagcal {
namespace {

using Eigen::Vector2d;

bool finite(const Segment2& s) { return s.from.allFinite() && s.to.allFinite(); }

// The point of the line from a to b on the border of the highest bit in `code`.
Vector2d at_border(const Window& w, const Vector2d& a, const Vector2d& b, std::uint8_t code) {
  const auto at_y = [&](double y) {
    return Vector2d(a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())), y);
  };
  const auto at_x = [&](double x) {
    return Vector2d(x, a.y() + (b.y() - a.y()) * ((x - a.x()) / (b.x() - a.x())));
  };
  if (code & kTop) return at_y(w.top);
  if (code & kBottom) return at_y(w.bottom);
  return at_x(code & kRight ? w.right : w.left);
}

}  // namespace

std::uint8_t outcode(const Window& window, const Vector2d& point) {
  std::uint8_t code = 0;
  if (point.x() < window.left) code |= kLeft;
  if (point.x() > window.right) code |= kRight;
  if (point.y() < window.bottom) code |= kBottom;
  if (point.y() > window.top) code |= kTop;
  return code;
}

std::optional<Segment2> clip_line_cohen_sutherland(const Window& window, const Segment2& segment) {
  if (!finite(segment)) return std::nullopt;
  Segment2 s = segment;
  std::uint8_t from = outcode(window, s.from), to = outcode(window, s.to);
  while (from | to) {
    if (from & to) return std::nullopt;  // both beyond one border
    // A cut sets one coordinate to the border exactly, so each border is cut once for each end.
    if (from) {
      s.from = at_border(window, s.from, s.to, from);
      from = outcode(window, s.from);
    } else {
      s.to = at_border(window, s.from, s.to, to);
      to = outcode(window, s.to);
    }
  }
  return s;
}

std::optional<Segment2> clip_line_liang_barsky(const Window& window, const Segment2& segment) {
  if (!finite(segment)) return std::nullopt;
  const Vector2d along = segment.to - segment.from;
  // Each border as p t <= q, the kept side.
  const std::pair<double, double> borders[] = {{-along.x(), segment.from.x() - window.left},
                                               {along.x(), window.right - segment.from.x()},
                                               {-along.y(), segment.from.y() - window.bottom},
                                               {along.y(), window.top - segment.from.y()}};
  double first = 0, last = 1;
  for (const auto& [p, q] : borders) {
    if (p == 0 && q < 0) return std::nullopt;  // parallel, and beyond
    if (p < 0) first = std::max(first, q / p);
    if (p > 0) last = std::min(last, q / p);
  }
  if (first > last) return std::nullopt;
  // The ends stay as they are where they are inside.
  return Segment2{first > 0 ? Vector2d(segment.from + first * along) : segment.from,
                  last < 1 ? Vector2d(segment.from + last * along) : segment.to};
}

}  // namespace tagcal
