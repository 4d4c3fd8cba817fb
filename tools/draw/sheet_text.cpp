#include "draw/sheet.hpp"

#include "draw/cairo.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kScale = 100;  // units of the outlines in a millimetre: curves are cut finely

// A context of no surface's own pixels, with the font.
class Font {
 public:
  explicit Font(double height_mm)
      : surface_(cairo_recording_surface_create(CAIRO_CONTENT_ALPHA, nullptr)),
        context_(cairo_create(surface_.get())) {
    cairo_select_font_face(context_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context_.get(), kScale * height_mm);
    const std::unique_ptr<cairo_font_options_t, decltype(&cairo_font_options_destroy)> options(
        cairo_font_options_create(), cairo_font_options_destroy);
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context_.get(), options.get());
  }

  cairo_t* context() const { return context_.get(); }

 private:
  CairoSurface surface_;
  CairoContext context_;
};

}  // namespace

std::vector<Contour> text_contours(const std::string& text, const Vector2d& baseline,
                                   double height_mm) {
  const Font font(height_mm);
  cairo_text_path(font.context(), text.c_str());
  const std::unique_ptr<cairo_path_t, decltype(&cairo_path_destroy)> path(
      cairo_copy_path_flat(font.context()), cairo_path_destroy);
  std::vector<Contour> contours;
  for (int i = 0; i < path->num_data; i += path->data[i].header.length) {
    const cairo_path_data_t* data = path->data + i;
    if (data->header.type == CAIRO_PATH_MOVE_TO) contours.emplace_back();
    if (data->header.type == CAIRO_PATH_CLOSE_PATH) continue;
    contours.back().push_back(baseline + Vector2d(data[1].point.x, data[1].point.y) / kScale);
  }
  std::erase_if(contours, [](const Contour& contour) { return contour.size() < 3; });
  return contours;
}

double text_width(const std::string& text, double height_mm) {
  const Font font(height_mm);
  cairo_text_extents_t extents;
  cairo_text_extents(font.context(), text.c_str(), &extents);
  return extents.x_advance / kScale;
}

}  // namespace tagcal::tools
