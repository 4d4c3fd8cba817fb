#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

namespace tagcal::internal {

// Most corners of an occluder, from files and programs: more is a mistake in the input. Source:
// none; chosen by hand.
constexpr std::size_t kMaxPolygonCorners = 1000;

// Why corners are no flat convex polygon, as the end of a sentence ("must not lie on a line"). No
// value if they are one. `corners`: three or more, finite.
std::optional<std::string> why_no_polygon(std::span<const Eigen::Vector3d> corners);

}  // namespace tagcal::internal
