#include "draw/labels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "draw/canvas.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using study::Drawing, study::Text;

constexpr double kNameSize = 8.8;  // of the letters, points
constexpr double kHeightPx = 13;   // of a name
constexpr double kHaloPx = 2.5;    // of the white line around letters
constexpr double kMarkPx = 3;      // half the size of a marked point
constexpr double kBesidePx = 12;   // beyond it a name has a line to its point
constexpr double kGapsPx[] = {5, 9, 14, 22, 32, 46, 64, 90, 120, 160, 220};
constexpr int kDirections = 24;

Window box_about(const Vector2d& centre, const Vector2d& size) {
  return {centre.x() - size.x() / 2, centre.x() + size.x() / 2, centre.y() - size.y() / 2,
          centre.y() + size.y() / 2};
}

bool overlap(const Window& a, const Window& b) {
  return a.left < b.right && b.left < a.right && a.bottom < b.top && b.bottom < a.top;
}

bool contains(const Window& outer, const Window& inner) {
  return outer.left <= inner.left && inner.right <= outer.right && outer.bottom <= inner.bottom &&
         inner.top <= outer.top;
}

Vector2d nearest(const Window& box, const Vector2d& point) {
  return {std::clamp(point.x(), box.left, box.right), std::clamp(point.y(), box.bottom, box.top)};
}

}  // namespace

void Labels::keep_free(const Vector2d& point) {
  taken_.push_back(box_about(point, Vector2d::Constant(2 * kMarkPx)));
}

bool Labels::is_free(const Window& box, const Segment2& leader) const {
  if (!contains(area_, box)) return false;
  for (const Window& other : taken_)
    if (overlap(box, other)) return false;
  for (const Segment2& other : leaders_)
    if (clip_line_liang_barsky(box, other)) return false;
  const Vector2d start = leader.from + 0.3 * (leader.to - leader.from);  // free of its own point
  return (leader.to - leader.from).norm() <= kBesidePx ||
         std::ranges::none_of(taken_, [&](const Window& other) {
           return clip_line_liang_barsky(other, {start, leader.to}).has_value();
         });
}

void Labels::add(std::string_view text, const Vector2d& point, std::string_view colour) {
  names_.push_back({.place = point,
                    .text = std::string(text),
                    .size = kNameSize,
                    .colour = std::string(colour),
                    .at = Text::At::middle,
                    .halo = kHaloPx});
}

void Labels::draw(Drawing& drawing) {
  for (const Text& name : names_) place(name, drawing);
}

void Labels::place(Text name, Drawing& drawing) {
  const Vector2d size(text_width(name) + 2, kHeightPx), point = name.place;
  for (const double gap : kGapsPx)
    for (int i = 0; i < kDirections; ++i) {
      // From the upper right on, to both sides in turn.
      const int turn = i % 2 ? -(i + 1) / 2 : i / 2;
      const double angle =
          (-0.125 + static_cast<double>(turn) / kDirections) * 2 * std::numbers::pi;
      const Vector2d direction(std::cos(angle), std::sin(angle));
      name.place = point + gap * direction + 0.5 * direction.cwiseProduct(size);
      const Window box = box_about(name.place, size);
      const Segment2 leader{point, nearest(box, point)};
      if (!is_free(box, leader)) continue;
      taken_.push_back(box);
      if ((leader.to - leader.from).norm() > kBesidePx) {
        leaders_.push_back(leader);
        drawing.line(leader.from, leader.to, name.colour, 0.6);
      }
      drawing.items.emplace_back(std::move(name));
      return;
    }
}

}  // namespace tagcal::tools
