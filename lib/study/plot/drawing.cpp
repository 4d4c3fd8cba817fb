#include "study/plot/drawing.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;

// Corners on a circle, the first one at this angle.
std::vector<Vector2d> corners(int count, double first_deg, const Vector2d& centre, double radius) {
  std::vector<Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double angle = internal::radians(first_deg + 360.0 * i / count);
    points.push_back(centre + radius * Vector2d(std::cos(angle), -std::sin(angle)));
  }
  return points;
}

std::vector<Vector2d> outline(Mark mark, const Vector2d& centre, double radius) {
  switch (mark) {
    case Mark::square:
      return corners(4, 45, centre, 1.25 * radius);
    case Mark::triangle:
      return corners(3, 90, centre, 1.3 * radius);
    case Mark::wedge:
      return corners(3, -90, centre, 1.3 * radius);
    case Mark::diamond:
      return corners(4, 0, centre, 1.3 * radius);
    default:
      return corners(24, 0, centre, radius);
  }
}

}  // namespace

void Drawing::line(const Vector2d& from, const Vector2d& to, std::string_view colour,
                   double width_px, double opacity, double dash) {
  items.emplace_back(Path{{from, to}, std::string(colour), width_px, opacity, dash});
}

void Drawing::area(double left, double top, double right, double bottom, std::string_view colour) {
  items.emplace_back(
      Path{{{left, top}, {right, top}, {right, bottom}, {left, bottom}}, std::string(colour)});
}

void Drawing::text(double x, double y, std::string_view text, double size, std::string_view colour,
                   Text::At at, bool upwards) {
  items.emplace_back(Text{{x, y}, std::string(text), size, std::string(colour), at, upwards});
}

void Drawing::texts(double x, double y, double line_height, std::span<const std::string> lines,
                    double size, std::string_view colour) {
  for (std::size_t i = 0; i < lines.size(); ++i)
    text(x, y + line_height * static_cast<double>(i), lines[i], size, colour);
}

void Drawing::add(const Drawing& part, const Vector2d& place) {
  for (auto item : part.items) {
    if (auto* const path = std::get_if<Path>(&item))
      for (Vector2d& point : path->points) point += place;
    else
      std::get<Text>(item).place += place;
    items.push_back(std::move(item));
  }
}

bool Drawing::has_text(std::string_view text) const {
  return std::ranges::any_of(items, [&](const auto& item) {
    const auto* found = std::get_if<Text>(&item);
    return found && found->text.find(text) != std::string::npos;
  });
}

void add_mark(Mark mark, bool filled, const Vector2d& place, double radius, std::string_view colour,
              Drawing& drawing) {
  constexpr double kLine = 1.1;
  if (mark == Mark::plus || mark == Mark::cross) {
    const std::vector<Vector2d> ends = corners(4, mark == Mark::plus ? 0 : 45, place, 1.2 * radius);
    drawing.line(ends[0], ends[2], colour, kLine);
    drawing.line(ends[1], ends[3], colour, kLine);
    return;
  }
  Path path{outline(mark, place, radius), std::string(colour)};
  if (!filled) {
    path.width = kLine;
    path.points.push_back(path.points.front());
  }
  drawing.items.emplace_back(std::move(path));
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines(1);
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width)
      lines.emplace_back();
    lines.back().append(lines.back().empty() ? "" : " ").append(word);
    text.remove_prefix(std::min(word.size() + 1, text.size()));
  }
  return lines;
}

std::vector<std::string> footnote(std::span<const std::string> origin) {
  return wrapped(fmt::format("{}", fmt::join(origin, " · ")), 150);
}

}  // namespace tagcal::study
