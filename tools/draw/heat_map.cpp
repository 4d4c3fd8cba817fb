#include "draw/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "job/shown_parameters.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr int kHeatMapWidth = 640, kColourBarHeight = 40;  // of a drawing, pixels
constexpr int kTitleHeight = 30, kBarHeight = 14, kBarMargin = 8;

struct HeatMap {
  ImageGrid grid;
  Eigen::MatrixXd values;  // at the nodes (rows x columns); what is not finite has the last colour
  double lowest_px = 0.001;
  double highest_px = 10;

  int height() const;  // of the drawing

  // 0 for the lowest value, 1 for the highest; between the nodes bilinear. `x` and `y` from 0 to 1
  // over the image.
  double level(double x, double y) const;

  // The place of a pixel in the drawing, which begins at `top`.
  Eigen::Vector2d place(const Eigen::Vector2d& pixel, double top) const;
};

double level_of(double value, const HeatMap& map) {
  if (!std::isfinite(value)) return 1;
  return std::clamp(
      std::log(std::max(value, 1e-300) / map.lowest_px) / std::log(map.highest_px / map.lowest_px),
      0.0, 1.0);
}

int HeatMap::height() const {
  const double ratio = static_cast<double>(grid.size.height) / grid.size.width;
  return static_cast<int>(std::clamp(std::lround(kHeatMapWidth * ratio), 16L, 4L * kHeatMapWidth));
}

double HeatMap::level(double x, double y) const {
  const double column = x * (grid.columns - 1), row = y * (grid.rows - 1);
  const auto c = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(column), 0, values.cols() - 2);
  const auto r = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(row), 0, values.rows() - 2);
  const double right = column - static_cast<double>(c), down = row - static_cast<double>(r);
  const auto at = [&](Eigen::Index i, Eigen::Index j) { return level_of(values(i, j), *this); };
  return (1 - down) * ((1 - right) * at(r, c) + right * at(r, c + 1)) +
         down * ((1 - right) * at(r + 1, c) + right * at(r + 1, c + 1));
}

Vector2d HeatMap::place(const Vector2d& pixel, double top) const {
  return {(pixel.x() + 0.5) * kHeatMapWidth / grid.size.width,
          top + (pixel.y() + 0.5) * height() / grid.size.height};
}

std::string hex(const Rgb& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

// The powers of ten on the scale.
std::vector<double> decades(const HeatMap& map) {
  std::vector<double> all;
  const int last = static_cast<int>(std::lround(std::log10(map.highest_px)));
  for (int i = static_cast<int>(std::lround(std::log10(map.lowest_px))); i <= last; ++i)
    all.push_back(std::pow(10.0, i));
  return all;
}

// The colour of a level.
Rgb heat_colour(double level) {
  static constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{49, 90, 170}, {66, 160, 160}, {150, 200, 110}, {245, 205, 90}, {200, 60, 45}}};
  const double at = level * (kStops.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(i);
  Rgb rgb;
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] =
        static_cast<std::uint8_t>(std::lround((1 - rest) * kStops[i][c] + rest * kStops[i + 1][c]));
  return rgb;
}

// The start of an SVG file of this height on white.
std::string heat_svg_head(int height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      kHeatMapWidth, height);
}

std::string heat_cells_svg(const HeatMap& map, double top) {
  constexpr int kFiner = 4;  // cells to a node
  std::string svg;
  const int columns = kFiner * (map.grid.columns - 1), rows = kFiner * (map.grid.rows - 1);
  const double w = static_cast<double>(kHeatMapWidth) / columns;
  const double h = static_cast<double>(map.height()) / rows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      svg += fmt::format(
          "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
          "fill=\"{}\"/>\n",
          column * w, top + row * h, w + 0.3, h + 0.3,
          hex(heat_colour(map.level((column + 0.5) / columns, (row + 0.5) / rows))));
  return svg;
}

// A dashed polygon around the pixels of a hull.
std::string heat_hull_svg(const HeatMap& map, std::span<const Vector2d> hull, double top) {
  std::string points;
  for (const Vector2d& pixel : hull) {
    const Vector2d at = map.place(pixel, top);
    points += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
  }
  return fmt::format(
      "<polygon points=\"{}\" fill=\"none\" stroke=\"#fff\" stroke-width=\"2\" "
      "stroke-dasharray=\"6 4\"/>\n",
      points);
}

// The texts of the values at some nodes.
std::string heat_numbers_svg(const HeatMap& map, double top,
                             const std::function<std::string(double)>& text_of) {
  std::string svg;
  for (int row = 1; row < map.grid.rows - 1; row += 3) {
    for (int column = 2; column < map.grid.columns - 1; column += 4) {
      const Vector2d at = map.place(map.grid.pixel(column, row), top);
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                         at.x(), at.y() + 4, text_of(map.values(row, column)));
    }
  }
  return svg;
}

// The scale, with a number for each power of ten.
std::string colour_bar_svg(const HeatMap& map, double top) {
  constexpr int kSteps = 64;
  const double width = kHeatMapWidth - 2.0 * kBarMargin;
  std::string svg;
  for (int i = 0; i < kSteps; ++i)
    svg += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{}\" fill=\"{}\"/>\n",
        kBarMargin + width * i / kSteps, top + 6, width / kSteps + 0.3, kBarHeight,
        hex(heat_colour((i + 0.5) / kSteps)));
  for (const double value : decades(map)) {
    const double level = level_of(value, map);
    const char* const anchor = level < 0.01 ? "start" : level > 0.99 ? "end" : "middle";
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{:g} px</text>\n",
                       kBarMargin + width * level, top + kBarHeight + 19, anchor, value);
  }
  return svg;
}

// The map and below it the scale, with a mark at each power of ten.
ImageRgb heat_picture(const HeatMap& map) {
  const int height = map.height();
  ImageRgb picture({kHeatMapWidth, height + 2 * kBarMargin + kBarHeight});
  const double width = kHeatMapWidth - 2.0 * kBarMargin;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < kHeatMapWidth; ++x) {
      const double along = (x + 0.5 - kBarMargin) / width;
      const int below = y - height - kBarMargin;
      Rgb colour = {255, 255, 255};
      if (y < height)
        colour = heat_colour(map.level((x + 0.5) / kHeatMapWidth, (y + 0.5) / height));
      else if (below >= 0 && below < kBarHeight && along >= 0 && along <= 1)
        colour = heat_colour(along);
      picture(x, y) = colour;
    }
  }
  for (const double value : decades(map)) {
    const int x =
        std::clamp(static_cast<int>(std::lround(kBarMargin + width * level_of(value, map))), 0,
                   kHeatMapWidth - 1);
    for (int y = height + kBarMargin; y < picture.height(); ++y) picture(x, y) = {0, 0, 0};
  }
  return picture;
}

HeatMap map_of(const LensFit& fit) { return {fit.grid, fit.difference_px}; }

HeatMap map_of(const ProjectionUncertainty& p) { return {p.grid, p.sigma_px}; }

std::string uncertainty_svg(const Calibration& calibration) {
  const int panel = map_of(calibration.projection.front()).height() + kTitleHeight;
  std::string svg = heat_svg_head(panel * static_cast<int>(calibration.projection.size()));
  for (std::size_t i = 0; i < calibration.projection.size(); ++i) {
    const ProjectionUncertainty& p = calibration.projection[i];
    const double title = static_cast<double>(panel) * static_cast<double>(i);
    const double top = title + kTitleHeight;
    const HeatMap map = map_of(p);
    svg += fmt::format(
        "<text x=\"8\" y=\"{:.0f}\">sd of the projection at {}, pixels per coordinate; dashed: "
        "where corners were</text>\n",
        title + 20, distance_text(p.distance_m));
    svg += heat_cells_svg(map, top) + heat_hull_svg(map, calibration.seen.hull(), top) +
           heat_numbers_svg(map, top, [&p](double sigma) {
             return std::isnan(sigma)               ? "no ray"
                    : has_bound(sigma, p.grid.size) ? fmt::format("{:.2g}", sigma)
                                                    : "no bound";
           });
  }
  return svg + "</svg>\n";
}

Image8 uncertainty_image(const Calibration& calibration) {
  const int height = map_of(calibration.projection.front()).height();
  Image8 image({kHeatMapWidth, height * static_cast<int>(calibration.projection.size())});
  for (std::size_t i = 0; i < calibration.projection.size(); ++i) {
    const HeatMap map = map_of(calibration.projection[i]);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < kHeatMapWidth; ++x)
        image(x, static_cast<int>(i) * height + y) = static_cast<std::uint8_t>(
            std::lround(255 * map.level((x + 0.5) / kHeatMapWidth, (y + 0.5) / height)));
  }
  return image;
}

}  // namespace

std::string lens_fit_svg(const LensFit& fit, const SeenRegion& seen) {
  const HeatMap map = map_of(fit);
  const int bottom = kTitleHeight + map.height();
  std::string svg = heat_svg_head(bottom + kColourBarHeight);
  svg +=
      fmt::format("<text x=\"8\" y=\"20\">difference of model {} from the lens, pixels{}</text>\n",
                  fit.model->name(), seen.hull().empty() ? "" : "; dashed: where corners were");
  svg += heat_cells_svg(map, kTitleHeight);
  if (!seen.hull().empty()) svg += heat_hull_svg(map, seen.hull(), kTitleHeight);
  svg += heat_numbers_svg(map, kTitleHeight, [](double px) {
    return std::isnan(px) ? "no ray" : std::isinf(px) ? "none" : fmt::format("{:.2g}", px);
  });
  return svg + colour_bar_svg(map, bottom) + "</svg>\n";
}

ImageRgb lens_fit_image(const LensFit& fit) { return heat_picture(map_of(fit)); }

std::string distance_text(double distance_m) {
  return std::isfinite(distance_m) ? fmt::format("{:.3g} m", distance_m) : "infinity";
}

void write_uncertainty_picture(const std::filesystem::path& file, const Calibration& calibration) {
  if (file.extension() == ".png")
    write_png(file, uncertainty_image(calibration));
  else
    write_whole(file, uncertainty_svg(calibration));
}

}  // namespace tagcal::tools
