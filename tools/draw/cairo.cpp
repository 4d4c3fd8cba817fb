#include "draw/cairo.hpp"

#include <fmt/format.h>

#include <cstring>

#include "tagcal/error.hpp"

namespace tagcal::tools {

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

}  // namespace tagcal::tools
