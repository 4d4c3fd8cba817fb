#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

// A sheet of paper in portrait, in millimetres (ISO 216; ANSI A).
struct Paper {
  std::string_view name;
  double width_mm = 0;
  double height_mm = 0;

  Paper landscape() const { return {name, height_mm, width_mm}; }
};

inline constexpr std::array kPapers = {Paper{"a4", 210, 297}, Paper{"letter", 215.9, 279.4},
                                       Paper{"a3", 297, 420}};

using Contour = std::vector<Eigen::Vector2d>;

// A page to print: black convex outlines that do not overlap, in millimetres from its upper-left
// corner, x right, y down; and letters, each outside or hole of a letter a closed line.
struct PrintedSheet {
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
PrintedSheet sheet_with_scale_bar(const std::vector<Contour>& ink_mm, const SheetFrame& frame);

// The least size of the page for ink of this size.
Eigen::Vector2d needed_size(const Eigen::Vector2d& ink_mm, const SheetFrame& frame);

// SVG whose user unit is the millimetre. Cairo would round to 1/256 of one, too coarse for small
// targets on glass.
std::string sheet_svg(const PrintedSheet& sheet, const std::string& title);

// The page in pixels; the grey level of a pixel is its exact share of ink.
ImageSize sheet_size(const PrintedSheet& sheet, double pixels_per_mm);
Image8 sheet_image(const PrintedSheet& sheet, double pixels_per_mm);

// The outlines of a line of text, in millimetres, y down: outsides of letters have one sense of
// rotation, holes the other one. `baseline` is the left end of the baseline, `height_mm` the size
// of the font (a sans-serif of the machine).
std::vector<Contour> text_contours(const std::string& text, const Eigen::Vector2d& baseline,
                                   double height_mm);

// A PDF of one page, true to scale.
std::string sheet_pdf(const PrintedSheet& sheet, const std::string& title);

// A page larger than the paper, cut into several that overlap.
struct Tiling {
  Paper paper;  // as it lies
  int columns = 0;
  int rows = 0;
};

// The tiling with the fewest pages, in portrait or landscape.
Tiling tiling_of(const PrintedSheet& sheet, const Paper& paper);

// A PDF with a page for each tile, row by row from above, with marks where to cut and join.
std::string tiled_pdf(const PrintedSheet& sheet, const Tiling& tiling, const std::string& title);

}  // namespace tagcal::tools
