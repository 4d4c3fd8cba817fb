#pragma once

#include <numbers>

// Degrees, which only files, messages and the command line have.
namespace tagcal::internal {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad

constexpr double degrees(double rad) { return rad * 180 / std::numbers::pi; }
constexpr double radians(double deg) { return deg * std::numbers::pi / 180; }

}  // namespace tagcal::internal
