#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "draw.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector2d>;

// True if all of `b` lies beyond one side of `a` (both convex, any orientation).
bool has_separating_side(const Polygon& a, const Polygon& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector2d side = a[(i + 1) % a.size()] - a[i];
    const Vector2d normal(-side.y(), side.x());
    double a_low = 0, a_high = 0, b_low = HUGE_VAL, b_high = -HUGE_VAL;
    for (const Vector2d& p : a) {
      a_low = std::min(a_low, normal.dot(p - a[i]));
      a_high = std::max(a_high, normal.dot(p - a[i]));
    }
    for (const Vector2d& p : b) {
      b_low = std::min(b_low, normal.dot(p - a[i]));
      b_high = std::max(b_high, normal.dot(p - a[i]));
    }
    if (b_low > a_high || b_high < a_low) return true;
  }
  return false;
}

// True if the occluder may hide a part of the paper, in the plane z = 0, from an eye above it.
bool cuts(const Occluder& occluder, const Polygon& paper, const Vector3d& eye) {
  Polygon shadow;
  for (const Vector3d& p : occluder.corners) {
    if (p.z() > 0.8 * eye.z()) return true;  // beside the eye or behind it
    const Vector3d x = eye + (p - eye) * eye.z() / (eye.z() - p.z());
    shadow.push_back(x.head<2>());
  }
  return !has_separating_side(shadow, paper) && !has_separating_side(paper, shadow);
}

Occluder draw_polygon(const Vector3d& centre, double radius_m, Random& random) {
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond{random.normal(), random.normal(), random.normal(), random.normal()}
          .normalized();  // braces: evaluated in this order
  Occluder occluder;
  occluder.level = random.uniform();
  const int count = 3 + static_cast<int>(random.index(4));
  const double start = random.uniform(0, 2 * std::numbers::pi), squeeze = random.uniform(0.3, 1);
  for (int i = 0; i < count; ++i) {
    const double angle = start + 2 * std::numbers::pi * i / count;
    occluder.corners.emplace_back(
        centre + turn * (radius_m * Vector3d(std::cos(angle), squeeze * std::sin(angle), 0)));
  }
  return occluder;
}

}  // namespace

std::vector<Occluder> draw_occluders(const Scene& scene, Random& random) {
  const Rectangle paper = board_panels(scene.boards[0].board, scene.paper_margin_m)[0].paper;
  Polygon outline;
  for (const Vector3d& p : paper) outline.push_back(p.head<2>());
  const Vector3d middle = (paper[0] + paper[2]) / 2;
  const double diagonal = (paper[2] - paper[0]).norm();
  std::vector<Occluder> occluders;
  const std::size_t count = 1 + random.index(4);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const double away = diagonal * random.uniform(0, 1.2);
    const Vector3d centre = middle + Vector3d(away * std::cos(angle), away * std::sin(angle),
                                              diagonal * random.uniform(-0.4, 0.15));
    const Occluder occluder = draw_polygon(centre, diagonal * random.uniform(0.05, 0.5), random);
    const bool behind = std::ranges::all_of(
        occluder.corners, [&](const Vector3d& p) { return p.z() < -1e-3 * diagonal; });
    const auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
    const bool harmless = behind || std::ranges::none_of(poses, [&](const Pose& pose) {
                            return cuts(occluder, outline, pose.inverse().translation());
                          });
    if (harmless) occluders.push_back(occluder);
  }
  return occluders;
}

}  // namespace tagcal
