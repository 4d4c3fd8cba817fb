#include "tagcal/detect/tag_fit/quad.hpp"

#include <algorithm>
#include <limits>

namespace tagcal::internal {
namespace {

// True if every corner turns by `way` as seen: clockwise 1, counter-clockwise -1.
bool turns(const Quad& quad, double way) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = quad[(i + 1) % 4] - quad[i];
    const Eigen::Vector2d b = quad[(i + 2) % 4] - quad[(i + 1) % 4];
    if (!(way * (a.x() * b.y() - a.y() * b.x()) > 0)) return false;
  }
  return true;
}

}  // namespace

bool is_inside(const Quad& quad, const ImageSize& size, double margin_px) {
  constexpr double kHalf = 1.0 / 2;  // px, from the outermost pixels' centres to the edge
  return std::all_of(quad.begin(), quad.end(), [&](const Eigen::Vector2d& corner) {
    return corner.minCoeff() >= -kHalf + margin_px &&
           corner.x() <= size.width - kHalf - margin_px &&
           corner.y() <= size.height - kHalf - margin_px;
  });
}

bool is_face(const Quad& quad) { return turns(quad, -1); }
bool is_mirrored(const Quad& quad) { return turns(quad, 1); }

double largest_distance(const Quad& a, const Quad& b) {
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

double shortest_side(const Quad& quad) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i)
    shortest = std::min(shortest, (quad[(i + 1) % 4] - quad[i]).norm());
  return shortest;
}

Eigen::Vector2d centre_of(const Quad& quad) { return (quad[0] + quad[1] + quad[2] + quad[3]) / 4; }

}  // namespace tagcal::internal
