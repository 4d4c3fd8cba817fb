#include "draw/cairo.hpp"

#include <cairo/cairo-svg.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "draw/canvas.hpp"
#include "job/plain_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using study::Drawing, study::Path, study::Text;

void set_colour(cairo_t* c, const std::string& colour, double opacity) {
  const unsigned long rgb = std::stoul(colour.substr(1), nullptr, 16);
  const auto part = [&](int shift) { return static_cast<double>(rgb >> shift & 255) / 255; };
  cairo_set_source_rgba(c, part(16), part(8), part(0), opacity);
}

void paint(const Path& path, cairo_t* c) {
  if (path.points.empty()) return;
  set_colour(c, path.colour, path.opacity);
  cairo_new_path(c);  // without the place where a text ended
  for (const Eigen::Vector2d& p : path.points) cairo_line_to(c, p.x(), p.y());
  if (path.width == 0) {
    cairo_fill(c);
    return;
  }
  cairo_set_line_width(c, path.width);
  cairo_set_dash(c, &path.dash, path.dash > 0 ? 1 : 0, 0);
  cairo_stroke(c);
}

// The letters as cairo takes them: it refuses what is not UTF-8.
std::string letters_of(const Text& text) { return one_line_text(text.text); }

// Selects the font; returns the width of these letters.
double set_font(const Text& text, const std::string& letters, cairo_t* c) {
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, 1.25 * text.size);  // sizes are points of 96 to an inch, as in a browser
  cairo_text_extents_t extents;
  cairo_text_extents(c, letters.c_str(), &extents);
  return extents.x_advance;
}

void paint(const Text& text, cairo_t* c) {
  const std::string letters = letters_of(text);
  const double width = set_font(text, letters, c);
  const double along = text.at == Text::At::left     ? 0
                       : text.at == Text::At::middle ? width / 2
                                                     : width;
  cairo_save(c);
  cairo_translate(c, text.place.x(), text.place.y());
  if (text.upwards) cairo_rotate(c, -std::numbers::pi / 2);
  const double baseline = 0.36 * 1.25 * text.size;  // half the height of a capital letter
  if (text.halo > 0) {
    cairo_move_to(c, -along, baseline);
    cairo_text_path(c, letters.c_str());
    cairo_set_source_rgb(c, 1, 1, 1);
    cairo_set_line_width(c, text.halo);
    cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
    cairo_stroke(c);
  }
  set_colour(c, text.colour, 1);
  cairo_move_to(c, -along, baseline);
  cairo_show_text(c, letters.c_str());
  cairo_restore(c);
}

void paint(const Drawing& drawing, cairo_surface_t* surface, double scale) {
  const CairoContext context(cairo_create(surface));
  cairo_t* const c = context.get();
  cairo_scale(c, scale, scale);
  cairo_set_source_rgb(c, 1, 1, 1);
  cairo_paint(c);
  for (const auto& item : drawing.items)
    std::visit([&](const auto& shape) { paint(shape, c); }, item);
}

}  // namespace

cairo_status_t append_to_text(void* text, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(text)->append(data, data + length);
  return CAIRO_STATUS_SUCCESS;
}

void check_cairo(cairo_surface_t* surface, std::string_view what) {
  const cairo_status_t status = cairo_surface_status(surface);
  if (status != CAIRO_STATUS_SUCCESS)
    throw Error(fmt::format("{} cannot be made: {}", what, cairo_status_to_string(status)));
}

// A pixel of CAIRO_FORMAT_RGB24 is a number of 32 bits, 0x00RRGGBB.
CairoSurface surface_of(const ImageRgb& image) {
  CairoSurface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width(), image.height()));
  check_cairo(surface.get(), "the drawing");
  unsigned char* const data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const auto& [r, g, b] = image(x, y);
      const std::uint32_t pixel = (std::uint32_t{r} << 16) | (std::uint32_t{g} << 8) | b;
      std::memcpy(data + y * stride + 4 * x, &pixel, sizeof pixel);
    }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

ImageRgb image_of(cairo_surface_t* surface) {
  cairo_surface_flush(surface);
  check_cairo(surface, "the drawing");
  ImageRgb image({cairo_image_surface_get_width(surface), cairo_image_surface_get_height(surface)});
  const unsigned char* const data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, data + y * stride + 4 * x, sizeof pixel);
      image(x, y) = {static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
                     static_cast<std::uint8_t>(pixel)};
    }
  return image;
}

double text_width(const Text& text) {
  const CairoSurface surface(cairo_recording_surface_create(CAIRO_CONTENT_ALPHA, nullptr));
  const CairoContext context(cairo_create(surface.get()));
  return set_font(text, letters_of(text), context.get());
}

std::string drawing_svg(const Drawing& drawing) {
  std::string text;
  const CairoSurface surface(
      cairo_svg_surface_create_for_stream(append_to_text, &text, drawing.width, drawing.height));
  cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
  paint(drawing, surface.get(), 1);
  cairo_surface_finish(surface.get());
  check_cairo(surface.get(), "the drawing");
  return text;
}

ImageRgb drawing_image(const Drawing& drawing, double pixels_per_unit) {
  const auto pixels = [&](double length) {
    return static_cast<int>(std::lround(pixels_per_unit * length));
  };
  const CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, pixels(drawing.width),
                                                        pixels(drawing.height)));
  paint(drawing, surface.get(), pixels_per_unit);
  return image_of(surface.get());
}

void write_drawing(const std::filesystem::path& file, const Drawing& drawing) {
  if (file.extension() == ".png")
    write_png(file, drawing_image(drawing, 1));
  else
    write_whole(file, drawing_svg(drawing));
}

}  // namespace tagcal::tools
