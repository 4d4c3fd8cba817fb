#include "draw/canvas.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

ImageRgb grey(const Image8& picture) {
  ImageRgb image(picture.size());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) image(x, y).fill(picture(x, y));
  return image;
}

// The parts of a line inside the window: cairo's coordinates have 24 bits before the point.
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

}  // namespace

Canvas::Canvas(const Image8& picture) : surface_(surface_of(grey(picture))) {}

Canvas::Canvas(const ImageSize& size, const Rgb& colour)
    : surface_(surface_of(ImageRgb(size, colour))) {}

void Canvas::draw(const std::vector<Polyline>& lines, const Pen& pen) {
  const CairoContext context(cairo_create(surface_.get()));
  cairo_t* const c = context.get();
  cairo_translate(c, 0.5, 0.5);  // pixels have their centres at whole numbers
  cairo_set_source_rgba(c, pen.colour[0] / 255.0, pen.colour[1] / 255.0, pen.colour[2] / 255.0,
                        pen.opacity);
  cairo_set_line_width(c, pen.width_px);
  cairo_set_line_cap(c, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_dash(c, &pen.dash_px, pen.dash_px > 0 ? 1 : 0, 0);
  const double margin = 2 * pen.width_px + 1;
  const Window window{-margin, cairo_image_surface_get_width(surface_.get()) + margin, -margin,
                      cairo_image_surface_get_height(surface_.get()) + margin};
  for (const Polyline& line : lines)
    for (const Polyline& part : clipped(line, window)) {
      cairo_new_sub_path(c);
      for (const Vector2d& p : part) cairo_line_to(c, p.x(), p.y());
    }
  cairo_stroke(c);
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
