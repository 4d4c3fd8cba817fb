#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

using Quad = std::array<Eigen::Vector2d, 4>;

// A page to print: black quads that do not overlap, in millimetres from its upper-left corner, x
// right, y down.
struct Sheet {
  double width_mm = 0;
  double height_mm = 0;
  std::vector<Quad> ink;
};

// A page with the ink (millimetres, x right, y up) in a white margin, and below it a bar of 100 mm
// with its label, to check the scale of the print with a ruler.
Sheet sheet_with_scale_bar(const std::vector<Quad>& ink_mm, double margin_mm);

// SVG whose user unit is the millimetre.
std::string sheet_svg(const Sheet& sheet, const std::string& title);

// The page in pixels; the grey level of a pixel is its exact share of ink.
ImageSize sheet_size(const Sheet& sheet, double pixels_per_mm);
Image8 sheet_image(const Sheet& sheet, double pixels_per_mm);

}  // namespace tagcal::tools
