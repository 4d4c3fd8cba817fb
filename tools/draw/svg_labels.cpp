#include "draw/svg_panel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "job/plain_text.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kFontPx = 11;
constexpr double kCharacterPx = 0.62 * kFontPx;  // of a wide typeface (DejaVu Sans) on the average
constexpr double kMarkPx = 3;                    // half the size of a marked point
constexpr double kBesidePx = 12;                 // beyond it a name has a line to its point
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

void SvgLabels::keep_free(const Vector2d& point) {
  taken_.push_back(box_about(point, Vector2d::Constant(2 * kMarkPx)));
}

bool SvgLabels::is_free(const Window& box, const Segment2& leader) const {
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

void SvgLabels::draw(const Name& name, const Window& box, const Segment2& leader) {
  taken_.push_back(box);
  if ((leader.to - leader.from).norm() > kBesidePx) {
    leaders_.push_back(leader);
    svg_ += fmt::format(
        "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"{}\" "
        "stroke-width=\"0.6\"/>\n",
        leader.from.x(), leader.from.y(), leader.to.x(), leader.to.y(), name.colour);
  }
  svg_ += fmt::format(
      "<text class=\"label\" x=\"{:.2f}\" y=\"{:.2f}\" data-box=\"{:.2f} {:.2f} {:.2f} {:.2f}\" "
      "font-size=\"{}\" fill=\"{}\" stroke=\"#fff\" stroke-width=\"2.5\" "
      "paint-order=\"stroke\">{}</text>\n",
      box.left + 1, box.top - 0.25 * kFontPx, box.left, box.bottom, box.right, box.top, kFontPx,
      name.colour, xml_text(name.text));
}

void SvgLabels::add(std::string_view text, const Vector2d& point, std::string_view colour) {
  names_.push_back({std::string(text), point, colour});
}

std::string SvgLabels::svg() {
  for (const Name& name : names_) place(name);
  return svg_;
}

void SvgLabels::place(const Name& name) {
  const auto num_characters = static_cast<double>(name.text.size());
  const Vector2d size(kCharacterPx * num_characters + 2, 1.2 * kFontPx);
  for (const double gap : kGapsPx)
    for (int i = 0; i < kDirections; ++i) {
      // From the upper right on, to both sides in turn.
      const int turn = i % 2 ? -(i + 1) / 2 : i / 2;
      const double angle =
          (-0.125 + static_cast<double>(turn) / kDirections) * 2 * std::numbers::pi;
      const Vector2d direction(std::cos(angle), std::sin(angle));
      const Window box =
          box_about(name.point + gap * direction + 0.5 * direction.cwiseProduct(size), size);
      const Segment2 leader{name.point, nearest(box, name.point)};
      if (is_free(box, leader)) return draw(name, box, leader);
    }
}

}  // namespace tagcal::tools
