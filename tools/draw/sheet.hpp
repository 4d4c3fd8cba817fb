#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

using Contour = std::vector<Eigen::Vector2d>;

// A page to print: black convex outlines that do not overlap, in millimetres from its upper-left
// corner, x right, y down; and letters, each outside or hole of a letter a closed line.
struct Sheet {
  double width_mm = 0;
  double height_mm = 0;
  std::vector<Contour> ink;
  std::vector<Contour> letters = {};
};

// What stands around the ink.
struct SheetFrame {
  double margin_mm = 0;                         // white around the ink
  std::vector<std::string> caption = {};        // lines beside or below the scale bar
  std::optional<Eigen::Vector2d> page_mm = {};  // size of the page; otherwise as needed
};

// A page with the ink (millimetres, x right, y up) in a white margin, and below it a bar of 100 mm
// with its label, to check the scale of the print with a ruler, and the caption. On a page of given
// size the ink is in the middle of what is above the bar; what does not fit reaches beyond the
// page: see `needed_size`.
Sheet sheet_with_scale_bar(const std::vector<Contour>& ink_mm, const SheetFrame& frame);

// The least size of the page for ink of this size.
Eigen::Vector2d needed_size(const Eigen::Vector2d& ink_mm, const SheetFrame& frame);

// SVG whose user unit is the millimetre.
std::string sheet_svg(const Sheet& sheet, const std::string& title);

// The page in pixels; the grey level of a pixel is its exact share of ink.
ImageSize sheet_size(const Sheet& sheet, double pixels_per_mm);
Image8 sheet_image(const Sheet& sheet, double pixels_per_mm);

}  // namespace tagcal::tools
