#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "tagcal/camera/canonical.hpp"

// Clipping of lines in the plane, to a window with y up; its border is inside.

namespace tagcal {

// Where a point lies, in Cohen and Sutherland's bits: top, bottom, right, left, from the highest.
// The nine regions, row by row from the top: 1001 1000 1010, 0001 0000 0010, 0101 0100 0110.
enum OutcodeBit : std::uint8_t { kLeft = 1, kRight = 2, kBottom = 4, kTop = 8 };
std::uint8_t outcode(const Window& window, const Eigen::Vector2d& point);

struct Segment2 {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

// The part of a segment inside the window; one point where it only touches. No value where there is
// none, or a coordinate is not finite. Two ways, the same answer: by the codes of the ends, one
// border at a time (Cohen & Sutherland 1967), and by the parameter along the line, all borders at
// once (Liang & Barsky, ACM TOG 1984).
std::optional<Segment2> clip_line_cohen_sutherland(const Window& window, const Segment2& segment);
std::optional<Segment2> clip_line_liang_barsky(const Window& window, const Segment2& segment);

}  // namespace tagcal
