#include "draw/canvas.hpp"

#include <cmath>
#include <numbers>
#include <optional>

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kCapital = 0.73;    // height of DejaVu's capital letters and digits, of its size
constexpr double kHaloWidth = 0.35;  // of the white line around a letter, of its height

ImageRgb grey(const Image8& picture) {
  ImageRgb image(picture.size());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) image(x, y).fill(picture(x, y));
  return image;
}

// A picture with a margin. Cairo's coordinates have 24 bits before the point, so that what is
// outside must not be drawn.
Window window_of(cairo_surface_t* surface, double margin) {
  return {-margin, cairo_image_surface_get_width(surface) + margin, -margin,
          cairo_image_surface_get_height(surface) + margin};
}

// Pixels have their centres at whole numbers.
CairoContext context_of(cairo_surface_t* surface) {
  CairoContext context(cairo_create(surface));
  cairo_translate(context.get(), 0.5, 0.5);
  cairo_set_line_cap(context.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
  return context;
}

void set_source(cairo_t* c, const Rgb& colour, double opacity) {
  cairo_set_source_rgba(c, colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0, opacity);
}

}  // namespace

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

Canvas::Canvas(const Image8& picture) : surface_(surface_of(grey(picture))) {}

Canvas::Canvas(const ImageSize& size, const Rgb& colour)
    : surface_(surface_of(ImageRgb(size, colour))) {}

void Canvas::draw(const std::vector<Polyline>& lines, const Pen& pen) {
  const CairoContext context = context_of(surface_.get());
  cairo_t* const c = context.get();
  set_source(c, pen.colour, pen.opacity);
  cairo_set_line_width(c, pen.width_px);
  cairo_set_dash(c, &pen.dash_px, pen.dash_px > 0 ? 1 : 0, 0);
  const Window window = window_of(surface_.get(), 2 * pen.width_px + 1);
  for (const Polyline& line : lines)
    for (const Polyline& part : clipped(line, window)) {
      cairo_new_sub_path(c);
      for (const Vector2d& p : part) cairo_line_to(c, p.x(), p.y());
    }
  cairo_stroke(c);
}

void Canvas::write(const Label& label, const Rgb& colour) {
  const Window window =
      window_of(surface_.get(), label.height_px * static_cast<double>(label.text.size()));
  if (!clip_line_liang_barsky(window, {label.middle, label.middle})) return;
  const CairoContext context = context_of(surface_.get());
  cairo_t* const c = context.get();
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_BOLD);
  cairo_set_font_size(c, label.height_px / kCapital);
  cairo_text_extents_t extents;
  cairo_text_extents(c, label.text.c_str(), &extents);
  cairo_move_to(c, label.middle.x() - extents.x_bearing - extents.width / 2,
                label.middle.y() - extents.y_bearing - extents.height / 2);
  cairo_text_path(c, label.text.c_str());
  set_source(c, {255, 255, 255}, 0.8);
  cairo_set_line_width(c, kHaloWidth * label.height_px);
  cairo_stroke_preserve(c);
  set_source(c, colour, 1);
  cairo_fill(c);
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
