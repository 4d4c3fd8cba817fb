#pragma once

#include <cairo/cairo.h>

#include <memory>
#include <string>
#include <string_view>

#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

struct CairoFree {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
using CairoSurface = std::unique_ptr<cairo_surface_t, CairoFree>;
using CairoContext = std::unique_ptr<cairo_t, CairoFree>;

// Appends what a surface writes to a std::string; a cairo_write_func_t.
cairo_status_t append_to_text(void* text, const unsigned char* data, unsigned int length);

// Throws Error if something has gone wrong; `what`: "the PDF".
void check_cairo(cairo_surface_t* surface, std::string_view what);

// Surfaces of colour pixels, from and to pictures.
CairoSurface surface_of(const ImageRgb& image);
ImageRgb image_of(cairo_surface_t* surface);

}  // namespace tagcal::tools
