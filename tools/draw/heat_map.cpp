#include "draw/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "job/shown_parameters.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using study::Drawing, study::Path, study::Text;

constexpr int kHeatMapWidth = 640, kColourBarHeight = 40;  // of a drawing, pixels
constexpr int kTitleHeight = 30, kBarHeight = 14, kBarMargin = 8;
constexpr int kSteps = 64;  // colours of the scale

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

// The powers of ten on the scale.
std::vector<double> decades(const HeatMap& map) {
  std::vector<double> all;
  const int last = static_cast<int>(std::lround(std::log10(map.highest_px)));
  for (int i = static_cast<int>(std::lround(std::log10(map.lowest_px))); i <= last; ++i)
    all.push_back(std::pow(10.0, i));
  return all;
}

// The colour of a level.
std::string heat_colour(double level) {
  static constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{49, 90, 170}, {66, 160, 160}, {150, 200, 110}, {245, 205, 90}, {200, 60, 45}}};
  const double at = level * (kStops.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(i);
  std::string colour = "#";
  for (std::size_t c = 0; c < 3; ++c)
    colour +=
        fmt::format("{:02x}", std::lround((1 - rest) * kStops[i][c] + rest * kStops[i + 1][c]));
  return colour;
}

// The level of the middle of its step on the scale.
double step_of(double level) {
  return (std::min(std::floor(level * kSteps), kSteps - 1.0) + 0.5) / kSteps;
}

// A rectangle that overlaps those to be drawn after it, so that no white shows between them.
void add_cell(double left, double top, double width, double height, double level,
              Drawing& drawing) {
  const double right = left + width + 1, bottom = top + height + 1;
  drawing.items.emplace_back(
      Path{{{left, top}, {right, top}, {right, bottom}, {left, bottom}}, heat_colour(level)});
}

void add_text(const Vector2d& middle, std::string text, Text::At at, Drawing& drawing) {
  constexpr double kSize = 9;
  drawing.items.emplace_back(Text{middle, std::move(text), kSize, std::string(study::kBlack), at});
}

// The colours, a dashed line around the pixels of a hull, and the values at some nodes.
void add_map(const HeatMap& map, std::span<const Vector2d> hull, double top,
             const std::function<std::string(double)>& text_of, Drawing& drawing) {
  constexpr int kFiner = 4;  // cells to a node
  const int columns = kFiner * (map.grid.columns - 1), rows = kFiner * (map.grid.rows - 1);
  const double w = static_cast<double>(kHeatMapWidth) / columns;
  const double h = static_cast<double>(map.height()) / rows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0, next = 0; column < columns; column = next) {
      const auto level_at = [&](int c) {
        return step_of(map.level((c + 0.5) / columns, (row + 0.5) / rows));
      };
      const double level = level_at(column);
      for (next = column + 1; next < columns && level_at(next) == level;) ++next;
      add_cell(column * w, top + row * h, (next - column) * w, h, level, drawing);
    }
  if (!hull.empty()) {
    Path around{{}, "#ffffff", 2, 1, 5};
    for (std::size_t i = 0; i <= hull.size(); ++i)
      around.points.push_back(map.place(hull[i % hull.size()], top));
    drawing.items.emplace_back(std::move(around));
  }
  for (int row = 1; row < map.grid.rows - 1; row += 3)
    for (int column = 2; column < map.grid.columns - 1; column += 4)
      add_text(map.place(map.grid.pixel(column, row), top), text_of(map.values(row, column)),
               Text::At::middle, drawing);
}

// The scale, with a number for each power of ten.
void add_colour_bar(const HeatMap& map, double top, Drawing& drawing) {
  const double width = kHeatMapWidth - 2.0 * kBarMargin;
  for (int i = 0; i < kSteps; ++i)
    add_cell(kBarMargin + width * i / kSteps, top + 6, width / kSteps, kBarHeight,
             (i + 0.5) / kSteps, drawing);
  for (const double value : decades(map)) {
    const double level = level_of(value, map);
    const Text::At at = level < 0.01   ? Text::At::left
                        : level > 0.99 ? Text::At::right
                                       : Text::At::middle;
    add_text({kBarMargin + width * level, top + kBarHeight + 15}, fmt::format("{:g} px", value), at,
             drawing);
  }
}

}  // namespace

Drawing uncertainty_drawing(const Calibration& calibration) {
  Drawing drawing{kHeatMapWidth, 0};
  for (const ProjectionUncertainty& p : calibration.projection) {
    const HeatMap map{p.grid, p.sigma_px};
    add_text({8, drawing.height + kTitleHeight / 2.0},
             fmt::format("sd of the projection at {}, pixels per coordinate; dashed: where corners "
                         "were",
                         distance_text(p.distance_m)),
             Text::At::left, drawing);
    add_map(
        map, calibration.seen.hull(), drawing.height + kTitleHeight,
        [&p](double sigma) {
          return std::isnan(sigma)               ? "no ray"
                 : has_bound(sigma, p.grid.size) ? fmt::format("{:.2g}", sigma)
                                                 : "no bound";
        },
        drawing);
    drawing.height += kTitleHeight + map.height();
    add_colour_bar(map, drawing.height, drawing);
    drawing.height += kColourBarHeight;
  }
  return drawing;
}

Drawing lens_fit_drawing(const LensFit& fit, const SeenRegion& seen) {
  const HeatMap map{fit.grid, fit.difference_px};
  const double bottom = kTitleHeight + map.height();
  Drawing drawing{kHeatMapWidth, bottom + kColourBarHeight};
  add_text({8, kTitleHeight / 2.0},
           fmt::format("difference of model {} from the lens, pixels{}", fit.model->name(),
                       seen.hull().empty() ? "" : "; dashed: where corners were"),
           Text::At::left, drawing);
  add_map(
      map, seen.hull(), kTitleHeight,
      [](double px) {
        return std::isnan(px) ? "no ray" : std::isinf(px) ? "none" : fmt::format("{:.2g}", px);
      },
      drawing);
  add_colour_bar(map, bottom, drawing);
  return drawing;
}

std::string distance_text(double distance_m) {
  return std::isfinite(distance_m) ? fmt::format("{:.3g} m", distance_m) : "infinity";
}

}  // namespace tagcal::tools
