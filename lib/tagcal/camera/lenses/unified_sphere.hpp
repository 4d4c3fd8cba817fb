#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace tagcal::internal {

// The unified model between a point on the unit sphere about its centre and the normalised image:
//   (x, y) = (X, Y) / (alpha d + (1 - alpha) Z),  d = |(X, Y, Z)|
// At the angle phi from the axis the radius is sin(phi) / (alpha + (1 - alpha) cos(phi)), with the
// slope (alpha cos(phi) + 1 - alpha) / (alpha + (1 - alpha) cos(phi))^2. The slope vanishes at
// cos(phi) = -(1 - alpha) / alpha, the denominator at cos(phi) = -alpha / (1 - alpha).
struct UnifiedSphere {
  double alpha = 0;

  // The domain is Z > -w d.
  double w() const { return std::min(alpha, 1 - alpha) / std::max(alpha, 1 - alpha); }

  // Z of the point (x, y, Z) that projects to (x, y), by the squared radius of (x, y). No value at
  // and beyond the radius of the fold, 1 / sqrt(2 alpha - 1).
  std::optional<double> depth(double radius_square) const {
    const double root = 1 - (2 * alpha - 1) * radius_square;
    if (!(root > 0)) return std::nullopt;
    return (1 - alpha * alpha * radius_square) / (alpha * std::sqrt(root) + 1 - alpha);
  }
};

}  // namespace tagcal::internal
