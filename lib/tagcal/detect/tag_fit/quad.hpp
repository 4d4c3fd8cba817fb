#pragma once

#include "tagcal/detect/tag_fit/refine_edges.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect: what can be said of a tag's four corners alone.
namespace tagcal::internal {

// Every corner away from the picture's edge: a tag nearer to it may be cut.
bool is_inside(const Quad& quad, const ImageSize& size, double margin_px = 1.5);

// Convex, and not mirrored: seen, the corners run counter-clockwise (the image's y points down).
bool is_face(const Quad& quad);

// Convex, but seen in a mirror.
bool is_mirrored(const Quad& quad);

double largest_distance(const Quad& a, const Quad& b);
double shortest_side(const Quad& quad);
Eigen::Vector2d centre_of(const Quad& quad);

}  // namespace tagcal::internal
