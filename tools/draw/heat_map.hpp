#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/lens_fit.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/uncertainty/seen_region.hpp"

// Values in pixels over an image, as colours on a logarithmic scale: blue, green, yellow, red.

namespace tagcal::tools {

inline constexpr int kHeatMapWidth = 640;  // of a drawing, pixels
inline constexpr int kColourBarHeight = 40;

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

// The colour of a level.
Rgb heat_colour(double level);

// The start of an SVG file of this height on white.
std::string heat_svg_head(int height);

std::string heat_cells_svg(const HeatMap& map, double top);

// A dashed polygon around the pixels of a hull.
std::string heat_hull_svg(const HeatMap& map, std::span<const Eigen::Vector2d> hull, double top);

// The texts of the values at some nodes.
std::string heat_numbers_svg(const HeatMap& map, double top,
                             const std::function<std::string(double)>& text_of);

// The scale, with a number for each power of ten.
std::string colour_bar_svg(const HeatMap& map, double top);

// The map and below it the scale, with a mark at each power of ten.
ImageRgb heat_picture(const HeatMap& map);

// The difference between a fitted lens and its source over the image, with the colour scale; the
// SVG also has numbers and the hull of `seen`. Red: from 10 px on, without a projection, and
// without a ray. Precondition: the fit has a grid of differences.
std::string lens_fit_svg(const LensFit& fit, const SeenRegion& seen);
ImageRgb lens_fit_image(const LensFit& fit);

// Writes the projection's standard deviation over the image, one panel per distance below each
// other: .svg with the hull of the corners, or .png, 640 pixels wide: black up to 0.001 px, white
// from 10 px on (and without a ray), logarithmic between. Preconditions: calibration.projection is
// not empty, calibration.camera has a value.
void write_uncertainty_picture(const std::filesystem::path& file, const Calibration& calibration);

std::string distance_text(double distance_m);  // "infinity" or "1.2 m"

}  // namespace tagcal::tools
