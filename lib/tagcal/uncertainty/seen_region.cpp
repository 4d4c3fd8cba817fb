#include "tagcal/uncertainty/seen_region.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tagcal/internal/text.hpp"
#include "tagcal/uncertainty/policy/policy.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr std::string_view kCorner = " corner";

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Andrew's monotone chain (Information Processing Letters 9, 1979).
std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull;
  const auto extend = [&hull](const Vector2d& p, std::size_t base) {
    while (hull.size() >= base + 2 &&
           cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const Vector2d& p : points) extend(p, 0);
  const std::size_t base = hull.empty() ? 0 : hull.size() - 1;
  for (auto p = points.rbegin(); p != points.rend(); ++p) extend(*p, base);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

// Points that can be on the hull: those that are not inside the octagon of the outermost points in
// eight directions (Akl & Toussaint, Information Processing Letters 7, 1978).
std::vector<Vector2d> hull_candidates(std::span<const Vector2d> pixels) {
  if (pixels.empty()) return {};
  const Vector2d directions[] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                 {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  std::vector<Vector2d> octagon(8, pixels[0]);
  for (const Vector2d& p : pixels)
    for (std::size_t i = 0; i < 8; ++i)
      if (directions[i].dot(p - octagon[i]) > 0) octagon[i] = p;
  std::vector<Vector2d> result = octagon;
  for (const Vector2d& p : pixels) {
    bool inside = true;
    for (std::size_t i = 0; i < 8 && inside; ++i)
      inside = cross(octagon[(i + 1) % 8] - octagon[i], p - octagon[i]) > 0 ||
               octagon[i] == octagon[(i + 1) % 8];
    if (!inside) result.push_back(p);
  }
  return result;
}

}  // namespace

Vector2d ImageGrid::pixel(int column, int row) const {
  constexpr double kBorder = -0.5;  // numeric: pixel (0, 0) is the centre of the first pixel
  return {kBorder + size.width * static_cast<double>(column) / (columns - 1),
          kBorder + size.height * static_cast<double>(row) / (rows - 1)};
}

std::vector<Vector2d> ImageGrid::pixels() const {
  std::vector<Vector2d> all;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) all.push_back(pixel(column, row));
  return all;
}

SeenRegion::SeenRegion(const ImageSize& size, std::span<const Vector2d> pixels)
    : size_(size), hull_(convex_hull(hull_candidates(pixels))) {
  if (hull_.size() < 3) hull_.clear();
}

bool SeenRegion::contains(const Vector2d& pixel) const {
  if (hull_.empty()) return false;
  for (std::size_t i = 0; i < hull_.size(); ++i) {
    const Vector2d& a = hull_[i];
    const Vector2d& b = hull_[(i + 1) % hull_.size()];
    if (cross(b - a, pixel - a) < 0) return false;
  }
  return true;
}

double SeenRegion::share() const {
  double twice_area = 0;
  for (std::size_t i = 0; i < hull_.size(); ++i)
    twice_area += cross(hull_[i], hull_[(i + 1) % hull_.size()]);
  return hull_.empty() ? 0 : twice_area / 2 / (static_cast<double>(size_.width) * size_.height);
}

std::vector<Vector2d> SeenRegion::samples() const {
  std::vector<Vector2d> inside;
  for (const Vector2d& p : ImageGrid{size_, 33, 21}.pixels())
    if (contains(p)) inside.push_back(p);
  constexpr std::size_t kEnough = 12;  // a grid with fewer nodes in the region is too coarse
  if (inside.size() >= kEnough || hull_.empty()) return inside;
  // A small region: its centre, and points between that and the corners of the hull.
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& p : hull_) middle += p / static_cast<double>(hull_.size());
  inside = {middle};
  for (const double share : {0.25, 0.5, 0.75, 1.0})  // numeric: quarters of the way
    for (const Vector2d& p : hull_) inside.emplace_back(middle + share * (p - middle));
  return inside;
}

std::vector<std::string> SeenRegion::missing_parts() const {
  if (hull_.empty()) return {};
  Vector2d low = hull_[0], high = hull_[0];
  for (const Vector2d& p : hull_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double kNear = policy::kCornerInset, kFar = 1 - policy::kCornerInset;
  const double w = size_.width, h = size_.height;
  std::vector<std::string> parts;
  if (low.x() > w / 3) parts.emplace_back("left third");
  if (high.x() < 2 * w / 3) parts.emplace_back("right third");
  if (low.y() > h / 3) parts.emplace_back("upper third");
  if (high.y() < 2 * h / 3) parts.emplace_back("lower third");
  // A corner is named only if neither of its sides is missing as a third.
  for (const bool right : {false, true}) {
    for (const bool low_side : {false, true}) {
      const Vector2d corner(right ? kFar * w : kNear * w, low_side ? kFar * h : kNear * h);
      const bool side_missing = (right ? high.x() < 2 * w / 3 : low.x() > w / 3) ||
                                (low_side ? high.y() < 2 * h / 3 : low.y() > h / 3);
      if (side_missing || contains(corner)) continue;
      parts.push_back(std::string(low_side ? "lower " : "upper ") + (right ? "right" : "left") +
                      std::string(kCorner));
    }
  }
  return parts;
}

std::optional<std::string> SeenRegion::gaps() const {
  if (hull_.empty())
    return "the corners cover no area of the image: the lens is extrapolated everywhere, so take "
           "views with the board in all parts of the image";
  const std::vector<std::string> parts = missing_parts();
  if (parts.empty()) return std::nullopt;
  std::vector<std::string> thirds, corners;
  for (const std::string& part : parts)
    (part.ends_with(kCorner) ? corners : thirds).push_back(part);
  for (std::string& corner : corners) corner.resize(corner.size() - kCorner.size());
  if (!corners.empty())
    thirds.push_back(listed(corners) + std::string(kCorner) + (corners.size() > 1 ? "s" : ""));
  return "no corners in the " + listed(thirds) +
         " of the image: the lens is extrapolated there, so take views with the board there";
}

}  // namespace tagcal
