#include "draw/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr int kBarHeight = 14, kBarMargin = 8;

double level_of(double value, const HeatMap& map) {
  if (!std::isfinite(value)) return 1;
  return std::clamp(
      std::log(std::max(value, 1e-300) / map.lowest_px) / std::log(map.highest_px / map.lowest_px),
      0.0, 1.0);
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

}  // namespace

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

}  // namespace tagcal::tools
