#include "draw/sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kBar = 100;  // mm, as all constants below
constexpr double kBarStroke = 0.4;
constexpr double kTick = 4;
constexpr double kGlyphHeight = 4;
constexpr double kGlyphStroke = 0.5;
constexpr double kGlyphWidth = 2.5;
constexpr double kGlyphAdvance = 3.5;

Quad rectangle(double left, double top, double right, double bottom) {
  return {Vector2d(left, bottom), Vector2d(right, bottom), Vector2d(right, top),
          Vector2d(left, top)};
}

// The strokes of the letters of the label, so that no font is needed.
void add_glyph(char letter, double left, double top, std::vector<Quad>& ink) {
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

void add_scale_bar(double left, double top, std::vector<Quad>& ink) {
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

// Adds up signed areas: after a running sum along each row, a cell contains the share of its pixel
// inside of the polygons (the accumulation buffer of Raph Levien's font-rs). Polygons must be
// inside of the picture and run counter-clockwise on the screen.
class Coverage {
 public:
  explicit Coverage(const ImageSize& size) : sums_({size.width + 2, size.height}) {}

  void add_edge(Vector2d p, Vector2d q) {
    if (p.y() == q.y()) return;
    const double direction = p.y() < q.y() ? 1 : -1;  // down the left side: the area begins
    if (p.y() > q.y()) std::swap(p, q);
    const double slope = (q.x() - p.x()) / (q.y() - p.y());
    const int last = std::min(sums_.height(), static_cast<int>(std::ceil(q.y())));
    double x = p.x();
    for (int row = static_cast<int>(p.y()); row < last; ++row) {
      const double height = std::min(row + 1.0, q.y()) - std::max<double>(row, p.y());
      const double next = x + slope * height;
      add_in_row(sums_.row(row), std::minmax(x, next), direction * height);
      x = next;
    }
  }

  Image8 picture() const {
    Image8 image({sums_.width() - 2, sums_.height()});
    for (int y = 0; y < image.height(); ++y) {
      double covered = 0;
      for (int x = 0; x < image.width(); ++x) {
        covered += sums_(x, y);
        image(x, y) =
            static_cast<std::uint8_t>(std::lround(255 * (1 - std::clamp(covered, 0.0, 1.0))));
      }
    }
    return image;
  }

 private:
  // The part of an edge in one row, from x.first to x.second: adds to each pixel the increase of
  // the area right of the edge.
  static void add_in_row(float* row, std::pair<double, double> x, double signed_height) {
    const int first = static_cast<int>(x.first);
    const int last = std::max(first + 1, static_cast<int>(std::ceil(x.second)));
    const double length = x.second - x.first;
    double before = 0;
    for (int i = first; i <= last; ++i) {
      double share = 1;  // of the row's height, right of the edge, in pixel i
      if (i < last) {
        const double from = std::max<double>(i, x.first);
        const double to = std::min(i + 1.0, x.second);
        const double crossed = length > 0 ? (to - from) / length : 1;
        const double passed = length > 0 ? (from - x.first) / length : 0;
        share = passed + crossed * (i + 1 - (from + to) / 2);
      }
      row[i] += static_cast<float>(signed_height * (share - before));
      before = share;
    }
  }

  ImageF sums_;
};

}  // namespace

Sheet sheet_with_scale_bar(const std::vector<Quad>& ink_mm, double margin_mm) {
  Eigen::AlignedBox2d box;
  for (const Quad& quad : ink_mm) {
    for (const Vector2d& corner : quad) box.extend(corner);
  }
  Sheet sheet;
  sheet.width_mm = std::max(box.sizes().x(), kBar) + 2 * margin_mm;
  const double left = (sheet.width_mm - box.sizes().x()) / 2;
  for (const Quad& quad : ink_mm) {
    Quad placed;
    for (int i = 0; i < 4; ++i) {
      placed[i] = {quad[i].x() - box.min().x() + left, box.max().y() - quad[i].y() + margin_mm};
    }
    sheet.ink.push_back(placed);
  }
  const double bar_top = box.sizes().y() + 2 * margin_mm;
  add_scale_bar(margin_mm, bar_top, sheet.ink);
  sheet.height_mm = bar_top + kTick + 2 + kGlyphHeight + margin_mm;
  return sheet;
}

std::string sheet_svg(const Sheet& sheet, const std::string& title) {
  std::string escaped;
  for (const char c : title) {
    escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  }
  // One path, so that there is no seam between cells that touch.
  std::string path;
  for (const Quad& quad : sheet.ink) {
    char command = 'M';
    for (const Vector2d& corner : quad) {
      path += fmt::format("{}{:.4f} {:.4f}", command, corner.x(), corner.y());
      command = 'L';
    }
    path += "Z\n";
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" height=\"{1:.4f}mm\" "
      "viewBox=\"0 0 {0:.4f} {1:.4f}\">\n<title>{2}</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<path fill=\"#000\" "
      "d=\"{3}\"/>\n</svg>\n",
      sheet.width_mm, sheet.height_mm, escaped, path);
}

ImageSize sheet_size(const Sheet& sheet, double pixels_per_mm) {
  const auto pixels = [&](double mm) {
    return static_cast<int>(std::min(std::ceil(mm * pixels_per_mm), 1e9));
  };
  return {pixels(sheet.width_mm), pixels(sheet.height_mm)};
}

Image8 sheet_image(const Sheet& sheet, double pixels_per_mm) {
  Coverage coverage(sheet_size(sheet, pixels_per_mm));
  for (const Quad& quad : sheet.ink) {
    for (int i = 0; i < 4; ++i) {
      coverage.add_edge(quad[i] * pixels_per_mm, quad[(i + 1) % 4] * pixels_per_mm);
    }
  }
  return coverage.picture();
}

}  // namespace tagcal::tools
