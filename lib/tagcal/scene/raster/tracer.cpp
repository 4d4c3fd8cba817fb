#include "tagcal/scene/raster/tracer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/viewing/clip.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kChordErrorPx = 1e-4;
constexpr double kLongestChordPx = 1e9;  // rounded by 1e-7 px; longer ones are not judged, but cut
constexpr int kDeepestCut = 12;          // an edge is halved at most so often

// Polygons are clipped at this distance (share of their size) in front of the camera.
constexpr double kNearShare = 1e-6;

enum class Shape { straight, gentle, bent };

// The shape of the image of an edge from a to b, judged by three ordered points between them:
// straight within the chord error; gentle if it is so close to a parabola that the chords between
// the points have half that error; else bent.
Shape shape(const Vector2d& a, const std::array<Vector2d, 3>& between, const Vector2d& b) {
  const Vector2d chord = b - a;
  const double length = chord.norm();
  if (length > kLongestChordPx) return Shape::bent;
  std::array<double, 3> along, off;
  double farthest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2d offset = between[i] - a;
    if (length < 1e-12) {
      farthest = std::max(farthest, offset.norm());
      continue;
    }
    along[i] = chord.dot(offset) / (length * length);
    off[i] = (chord.x() * offset.y() - chord.y() * offset.x()) / length;
    farthest = std::max(farthest, std::abs(off[i]));
  }
  if (farthest < kChordErrorPx) return Shape::straight;
  if (length < 1e-12) return Shape::bent;
  const double steps[] = {along[0], along[1] - along[0], along[2] - along[1], 1 - along[2]};
  if (*std::ranges::min_element(steps) < 0.05) return Shape::bent;
  // off = height * 4 t (1 - t); a chord over a step of t has the error height * step^2.
  const double height = off[1] / (4 * along[1] * (1 - along[1]));
  const double longest = *std::ranges::max_element(steps);
  const auto misses = [&](std::size_t i) {
    return std::abs(off[i] - height * 4 * along[i] * (1 - along[i]));
  };
  const double error = std::abs(height) * longest * longest + misses(0) + misses(2);
  return error < kChordErrorPx / 2 ? Shape::gentle : Shape::bent;
}

}  // namespace

std::vector<std::vector<Vector3d>> Tracer::in_domain(const std::vector<Vector3d>& polygon) const {
  const double near_m = kNearShare * (polygon[0] - polygon[polygon.size() / 2]).norm();
  return clip_to_domain(polygon, camera_.lens, near_m);
}

void Tracer::trace(std::span<const Vector3d> polygon, Outlines& outlines) const {
  std::vector<Point> corners;
  for (const Vector3d& corner : polygon) {
    const std::optional<Point> point = imaged(corner);
    if (!point) return;
    corners.push_back(*point);
  }
  std::vector<Vector2d> traced;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (!follow_edge(corners[i], corners[(i + 1) % corners.size()], traced)) return;
  if (traced.size() >= 3) outlines.add(traced);
}

std::optional<Tracer::Point> Tracer::imaged(const Vector3d& x_in_camera) const {
  const std::optional<Vector2d> pixel = project(camera_.lens, x_in_camera);
  if (!pixel) return std::nullopt;
  return Point{x_in_camera, *pixel};
}

void Tracer::emit(const Point& point, std::vector<Vector2d>& out) const {
  out.push_back(scale_ * (point.pixel + Vector2d(0.5, 0.5)));
}

// Appends the image of the edge from a up to, not including, b.
bool Tracer::follow_edge(const Point& a, const Point& b, std::vector<Vector2d>& out) const {
  const std::optional<Point> middle = imaged(0.5 * (a.x_in_camera + b.x_in_camera));
  return middle && follow(a, *middle, b, kDeepestCut, out);
}

// All are beyond the same side of the image, where the picture does not show how a curve bends.
bool Tracer::is_far_beside(std::initializer_list<const Point*> points) const {
  constexpr double kFar = 10;  // sides of the image; a blur mixes what lies beside it into it
  const ImageSize& size = camera_.image_size;
  const double far = kFar * std::max(size.width, size.height);
  Eigen::AlignedBox2d box;
  for (const Point* point : points) box.extend(point->pixel);
  const Vector2d end(size.width + far, size.height + far);
  return (box.max().array() < -far).any() || (box.min().array() > end.array()).any();
}

bool Tracer::follow(const Point& a, const Point& middle, const Point& b, int depth,
                    std::vector<Vector2d>& out) const {
  const std::optional<Point> before = imaged(0.5 * (a.x_in_camera + middle.x_in_camera));
  const std::optional<Point> after = imaged(0.5 * (middle.x_in_camera + b.x_in_camera));
  if (!before || !after) return false;
  if (is_far_beside({&a, &*before, &middle, &*after, &b})) {
    emit(a, out);
    return true;
  }
  const Shape seen = shape(a.pixel, {before->pixel, middle.pixel, after->pixel}, b.pixel);
  if (seen == Shape::bent && depth > 0)
    return follow(a, *before, middle, depth - 1, out) && follow(middle, *after, b, depth - 1, out);
  emit(a, out);
  if (seen == Shape::straight) return true;
  for (const Point* point : {&*before, &middle, &*after}) emit(*point, out);
  return true;
}

}  // namespace tagcal::internal
