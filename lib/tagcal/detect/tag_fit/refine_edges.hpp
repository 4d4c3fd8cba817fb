#pragma once

#include <optional>

#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// The shape of a tag, as far as the fit of its sides needs it.
struct QuadShape {
  int cells = 8;            // along a side: the edge's neighbours lie one cell inside and outside
  bool dark_inside = true;  // false for families with a reversed border
};

// Fits each edge of a quad to the grey levels around it, as a blurred step along a slightly bent
// line, by least squares on the pixels themselves (without interpolation, so that the pixels'
// errors stay independent), and intersects neighbouring edges. The ends of the edges are not used:
// there the neighbouring edges, and the corner squares of Kalibr's boards, disturb the step. No
// value if an edge cannot be fitted (too short, or no contrast of the right sign), or if a corner
// moves by more than 2 px.
std::optional<Quad> refine_edges(const ImageView8& image, const Quad& start,
                                 const QuadShape& shape);

}  // namespace tagcal::internal
