#pragma once

#include <string>

#include "draw/sheet.hpp"

namespace tagcal::tools {

// The outlines of a line of text, in millimetres, y down: outsides of letters have one sense of
// rotation, holes the other one. `baseline` is the left end of the baseline, `height_mm` the size
// of the font (a sans-serif of the machine).
std::vector<Contour> text_contours(const std::string& text, const Eigen::Vector2d& baseline,
                                   double height_mm);

double text_width(const std::string& text, double height_mm);

}  // namespace tagcal::tools
