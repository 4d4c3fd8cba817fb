#include "draw/sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "draw/cairo.hpp"
#include "job/plain_text.hpp"
#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr double kBar = 100;  // mm, as all constants below
constexpr double kBarStroke = 0.4;
constexpr double kTick = 4;
constexpr double kGlyphHeight = 4;
constexpr double kGlyphStroke = 0.5;
constexpr double kGlyphWidth = 2.5;
constexpr double kGlyphAdvance = 3.5;
constexpr double kTextHeight = 3;
constexpr double kLineHeight = 4;
constexpr double kCaptionGap = 8;

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

double text_width(const std::string& text, double height_mm) {
  const Font font(height_mm);
  cairo_text_extents_t extents;
  cairo_text_extents(font.context(), text.c_str(), &extents);
  return extents.x_advance / kScale;
}

Contour rectangle(double left, double top, double right, double bottom) {
  return {Vector2d(left, bottom), Vector2d(right, bottom), Vector2d(right, top),
          Vector2d(left, top)};
}

// The strokes of the letters of the label, so that no font is needed.
void add_glyph(char letter, double left, double top, std::vector<Contour>& ink) {
  const double right = left + kGlyphWidth;
  const double bottom = top + kGlyphHeight;
  const double s = kGlyphStroke;
  const double middle = (left + right - s) / 2;
  if (letter == '1') ink.push_back(rectangle(middle, top, middle + s, bottom));
  if (letter == '0') {
    ink.push_back(rectangle(left, top, left + s, bottom));
    ink.push_back(rectangle(right - s, top, right, bottom));
    ink.push_back(rectangle(left + s, top, right - s, top + s));
    ink.push_back(rectangle(left + s, bottom - s, right - s, bottom));
  }
  if (letter == 'm') {
    const double x_height = top + kGlyphHeight * 0.4;
    ink.push_back(rectangle(left, x_height, right, x_height + s));
    for (const double x : {left, middle, right - s}) {
      ink.push_back(rectangle(x, x_height + s, x + s, bottom));
    }
  }
}

void add_scale_bar(double left, double top, std::vector<Contour>& ink) {
  // The outer edges of the end ticks are 100 mm apart.
  ink.push_back(rectangle(left, top, left + kBarStroke, top + kTick));
  ink.push_back(rectangle(left + kBar - kBarStroke, top, left + kBar, top + kTick));
  const double middle = top + (kTick - kBarStroke) / 2;
  ink.push_back(
      rectangle(left + kBarStroke, middle, left + kBar - kBarStroke, middle + kBarStroke));
  double x = left;
  for (const char letter : std::string_view("100 mm")) {
    add_glyph(letter, x, top + kTick + 2, ink);
    x += kGlyphAdvance;
  }
}

// All contours as one outline: the ways from contour to contour and back cancel, and the holes of
// letters keep their sign.
Contour chained(const std::vector<Contour>& contours, double scale) {
  Contour outline;
  for (const Contour& contour : contours) {
    for (const Vector2d& point : contour) outline.push_back(scale * point);
    outline.push_back(scale * contour.front());
  }
  for (std::size_t i = contours.size(); i > 1; --i)
    outline.push_back(scale * contours[i - 2].front());
  return outline;
}

// The scale bar with its label and the caption: the caption's first baseline from the bar's upper
// left corner, and the size of all.
struct Footer {
  Vector2d caption = Vector2d::Zero();
  Vector2d size = {kBar, kTick + 2 + kGlyphHeight};
};

// The caption is on the right of the bar if the page is wide enough, otherwise below.
Footer footer_of(double page_width, const SheetFrame& frame) {
  Footer footer;
  if (frame.caption.empty()) return footer;
  double width = 0;
  for (const std::string& line : frame.caption)
    width = std::max(width, text_width(line, kTextHeight));
  const double height = static_cast<double>(frame.caption.size()) * kLineHeight;
  if (page_width - 2 * frame.margin_mm >= kBar + kCaptionGap + width) {
    footer.caption = {kBar + kCaptionGap, kTextHeight};
    footer.size = {kBar + kCaptionGap + width, std::max(footer.size.y(), height)};
  } else {
    footer.caption = {0, footer.size.y() + kLineHeight};
    footer.size = {std::max(kBar, width), footer.caption.y() + height - kLineHeight / 2};
  }
  return footer;
}

}  // namespace

PrintedSheet sheet_with_scale_bar(const std::vector<Contour>& ink_mm, const SheetFrame& frame) {
  Eigen::AlignedBox2d box;
  for (const Contour& outline : ink_mm) {
    for (const Vector2d& corner : outline) box.extend(corner);
  }
  const Vector2d size = frame.page_mm.value_or(needed_size(box.sizes(), frame));
  const Footer footer = footer_of(size.x(), frame);
  PrintedSheet sheet{size.x(), size.y(), {}};
  const double bar_top = size.y() - frame.margin_mm - footer.size.y();
  const double left = (size.x() - box.sizes().x()) / 2, top = (bar_top - box.sizes().y()) / 2;
  for (const Contour& outline : ink_mm) {
    Contour& placed = sheet.ink.emplace_back();
    for (const Vector2d& corner : outline)
      placed.emplace_back(corner.x() - box.min().x() + left, box.max().y() - corner.y() + top);
  }
  add_scale_bar(frame.margin_mm, bar_top, sheet.ink);
  Vector2d at = Vector2d(frame.margin_mm, bar_top) + footer.caption;
  for (const std::string& line : frame.caption) {
    const std::vector<Contour> letters = text_contours(line, at, kTextHeight);
    sheet.letters.insert(sheet.letters.end(), letters.begin(), letters.end());
    at.y() += kLineHeight;
  }
  return sheet;
}

Vector2d needed_size(const Vector2d& ink_mm, const SheetFrame& frame) {
  const double width = std::max(ink_mm.x(), kBar) + 2 * frame.margin_mm;
  const Footer footer = footer_of(frame.page_mm ? frame.page_mm->x() : width, frame);
  return {std::max(width, footer.size.x() + 2 * frame.margin_mm),
          ink_mm.y() + 3 * frame.margin_mm + footer.size.y()};
}

std::string sheet_svg(const PrintedSheet& sheet, const std::string& title) {
  // One path, so that there is no seam between cells that touch.
  std::string path;
  const auto add = [&](const Contour& contour, int decimals) {
    char command = 'M';
    for (const Vector2d& point : contour) {
      path += fmt::format("{0}{1:.{3}f} {2:.{3}f}", command, point.x(), point.y(), decimals);
      command = 'L';
    }
    path += "Z\n";
  };
  for (const Contour& outline : sheet.ink) add(outline, 4);
  for (const Contour& letter : sheet.letters) add(letter, 3);
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" height=\"{1:.4f}mm\" "
      "viewBox=\"0 0 {0:.4f} {1:.4f}\">\n<title>{2}</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<path fill=\"#000\" "
      "d=\"{3}\"/>\n</svg>\n",
      sheet.width_mm, sheet.height_mm, xml_text(title), path);
}

ImageSize sheet_size(const PrintedSheet& sheet, double pixels_per_mm) {
  const auto pixels = [&](double mm) {
    return static_cast<int>(std::min(std::ceil(mm * pixels_per_mm), 1e9));
  };
  return {pixels(sheet.width_mm), pixels(sheet.height_mm)};
}

Image8 sheet_image(const PrintedSheet& sheet, double pixels_per_mm) {
  Outlines ink;
  for (Contour outline : sheet.ink) {
    for (Vector2d& corner : outline) corner *= pixels_per_mm;
    ink.add(outline);
  }
  ink.add(chained(sheet.letters, pixels_per_mm));
  Image8 image(sheet_size(sheet, pixels_per_mm), 255);
  CoverageBand band(image.width(), image.height());
  band.accumulate(ink.edges());
  band.drain([&](int row, int first, int end, float share) {
    const double light = 1 - std::clamp<double>(share, 0, 1);
    std::fill(image.row(row) + first, image.row(row) + end,
              static_cast<std::uint8_t>(std::lround(255 * light)));
  });
  return image;
}

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

}  // namespace tagcal::tools
