#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/raster/tracer.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

const std::array<Lens, 5> kLenses = {
    Lens(pinhole(900, 898, 645, 395)),
    Lens(Perspective({900, 898, 645, 395, -0.25, 0.08, 5e-4, -3e-4})),
    Lens(Perspective({700, 700, 645, 395, 0.2, -0.1, 1e-3, -5e-4, 2e-3, 0.35, 0.05, 0.01})),
    Lens(Fisheye({420, 419, 633, 405, 0.02, -0.01, 0.003, -0.0005})),
    Lens(Parallel({800, 810, 640, 400}))};

Polygon square(double side, Random& random) {
  const Pose pose(
      exp_rotation({random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), random.uniform(-3, 3)}),
      {random.uniform(-0.4, 0.4), random.uniform(-0.25, 0.25), 1});
  Polygon corners;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    corners.push_back(pose * Vector3d(0.5 * side * x, 0.5 * side * y, 0));
  return corners;
}

double distance(const Vector2d& p, const Outlines::Edge& edge) {
  const Vector2d along = edge.to - edge.from;
  const double length = along.squaredNorm();
  const double share = length > 0 ? std::clamp(along.dot(p - edge.from) / length, 0.0, 1.0) : 0.0;
  return (edge.from + share * along - p).norm();
}

// How far the image of the polygon's outline is from chords, in pixels, by many points of it.
double farthest_from(const Outlines& outlines, const Polygon& polygon, const Lens& lens,
                     double scale) {
  double farthest = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    for (int k = 0; k < 500; ++k) {
      const Vector3d x = polygon[i] + k / 500.0 * (polygon[(i + 1) % polygon.size()] - polygon[i]);
      const Vector2d p = scale * (*project(lens, x) + Vector2d(0.5, 0.5));
      double nearest = 1e9;
      for (const Outlines::Edge& edge : outlines.edges())
        nearest = std::min(nearest, distance(p, edge));
      farthest = std::max(farthest, nearest / scale);
    }
  }
  return farthest;
}

constexpr ImageSize kImage{1280, 800};

TEST(RenderTracer, ChordsLieWithinTheirErrorOfTheCurve) {
  Random random(1);
  for (std::size_t l = 0; l < kLenses.size(); ++l) {
    for (const double side : {0.01, 0.1, 0.4}) {
      for (const double scale : {1.0, 4.0}) {
        const Camera camera{kLenses[l], kImage};
        const Tracer tracer(camera, scale);
        const Polygon polygon = square(side, random);
        ASSERT_EQ(tracer.in_domain(polygon), std::vector<Polygon>{polygon});
        Outlines outlines;
        tracer.trace(polygon, outlines);
        EXPECT_LT(farthest_from(outlines, polygon, kLenses[l], scale), 1e-4)
            << "lens " << l << " side " << side;
        // As straight lines where they are (a pinhole's, parallel rays').
        if (l == 0 || l == 4) {
          EXPECT_EQ(outlines.edges().size(), 4u);
        }
      }
    }
  }
}

TEST(RenderTracer, AcrossTheBorderOfTheDomainNothingIsSeenWhole) {
  const Polygon floor = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 5}, {-1, 1, 5}};  // reaches behind
  EXPECT_NE(Tracer({kLenses[0], kImage}, 1).in_domain(floor), std::vector<Polygon>{floor});
  const Lens folding = Perspective({900, 898, 645, 395, -0.3});
  const Polygon wide = {{-3, -3, 1}, {3, -3, 1}, {3, 3, 1}, {-3, 3, 1}};
  const Camera camera{folding, kImage};
  const Tracer tracer(camera, 1);
  const std::vector<Polygon> seen = tracer.in_domain(wide);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_NE(seen[0], wide);
  Outlines outlines;
  tracer.trace(seen[0], outlines);
  EXPECT_GT(outlines.edges().size(), 100u);
  const Polygon behind = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}};
  EXPECT_NE(Tracer({kLenses[3], kImage}, 1).in_domain(behind), std::vector<Polygon>{behind});
}

// Each cut of what is far beside the image would be as long as before.
TEST(RenderTracer, FewChordsAreFarBesideTheImage) {
  const Polygon square = {{-0.1, -0.1, 1}, {0.1, -0.1, 1}, {0.1, 0.1, 1}, {-0.1, 0.1, 1}};
  const Polygon in_the_corner = {{0, 0, 1}, {0.1, 0, 1}, {0.1, 0.1, 1}, {0, 0.1, 1}};
  for (const Lens& lens :
       {Lens(pinhole(1e15, 1e15, 640, 400)), Lens(pinhole(1e300, 1e300, 640, 400)),
        Lens(Perspective({500, 500, 640, 400, 1e6})),
        Lens(Perspective({500, 500, 640, 400, 1e12}))}) {
    const Camera camera{lens, kImage};
    Outlines outlines;
    Tracer(camera, 1).trace(square, outlines);
    Tracer(camera, 1).trace(in_the_corner, outlines);
    EXPECT_GE(outlines.edges().size(), 8u);
    EXPECT_LT(outlines.edges().size(), 1000u);
  }
}

}  // namespace
}  // namespace tagcal
