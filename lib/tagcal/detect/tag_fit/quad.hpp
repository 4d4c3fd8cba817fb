#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// A tag's four corners: 0..3, pixel centres at whole numbers.
using Quad = std::array<Eigen::Vector2d, 4>;

// True if every corner is at least `margin_px` inside the picture's edge: a nearer tag may be cut.
bool is_inside(const Quad& quad, const ImageSize& size,
               double margin_px = policy::kTagEdgeMarginPx);

// True if convex and not mirrored: the corners run counter-clockwise as seen (the image's y points
// down).
bool is_face(const Quad& quad);

// True if convex and mirrored.
bool is_mirrored(const Quad& quad);

// The quad of f(corner); no value if a corner has none.
template <typename F>
std::optional<Quad> mapped(const Quad& quad, const F& f) {
  Quad result;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::optional<Eigen::Vector2d> at = f(quad[i]);
    if (!at) return std::nullopt;
    result[i] = *at;
  }
  return result;
}

double largest_distance(const Quad& a, const Quad& b);
double shortest_side(const Quad& quad);
Eigen::Vector2d centre_of(const Quad& quad);

}  // namespace tagcal::internal
