#include "draw/heat_map.hpp"

#include <fmt/format.h>

#include <cmath>

#include "job/shown_parameters.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

constexpr int kTitleHeight = 30;

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
