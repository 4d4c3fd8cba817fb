#include "draw/heat_map.hpp"

#include <fmt/format.h>

#include <cmath>

namespace tagcal::tools {
namespace {

constexpr int kTitleHeight = 30;

HeatMap map_of(const LensFit& fit) { return {fit.grid, fit.difference_px}; }

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

}  // namespace tagcal::tools
