#include "tagcal/camera/clip.hpp"

#include <gtest/gtest.h>

#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;
const std::vector<Vector3d> kSquare = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

TEST(ClipPolygon, KeepsCutsAndDrops) {
  EXPECT_EQ(clip_polygon(kSquare, {Vector3d::UnitX(), -1}), kSquare);
  EXPECT_TRUE(clip_polygon(kSquare, {Vector3d::UnitX(), 2}).empty());
  const auto half = clip_polygon(kSquare, {Vector3d::UnitX(), 0.25});
  ASSERT_EQ(half.size(), 4u);
  for (const Vector3d& x : half) EXPECT_GE(x.x(), 0.25);
}

TEST(ClipPolygon, ASharedEdgeIsCutAtOnePoint) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d a(random.normal(), random.normal(), -random.uniform(0.1, 1));
    const Vector3d b(random.normal(), random.normal(), random.uniform(0.1, 1));
    const auto one = clip_polygon({a, b, Vector3d(3, 3, 1)}, {Vector3d::UnitZ(), 0});
    const auto other = clip_polygon({b, a, Vector3d(-3, 3, 1)}, {Vector3d::UnitZ(), 0});
    const auto shared = std::ranges::count_if(
        one, [&](const Vector3d& x) { return std::ranges::find(other, x) != other.end(); });
    EXPECT_EQ(shared, 2);  // b and the cut
  }
}

TEST(ClipToDomain, EverythingLeftCanBeProjected) {
  Random random(2);
  const Lens lenses[] = {pinhole(500, 500, 0, 0), Perspective({500, 500, 0, 0, -0.3}),
                         Fisheye({300, 300, 0, 0, -0.2}), Fisheye({300, 300, 0, 0})};
  for (const Lens& lens : lenses) {
    int kept = 0;
    for (int i = 0; i < 300; ++i) {
      std::vector<Vector3d> triangle;
      for (int k = 0; k < 3; ++k)
        triangle.emplace_back(random.normal(), random.normal(), random.normal() + 0.5);
      const auto clipped = clip_to_domain(triangle, lens, 1e-6);
      for (const Vector3d& x : clipped) EXPECT_TRUE(in_domain(lens, x));
      kept += !clipped.empty();
    }
    EXPECT_GT(kept, 30);
  }
}

}  // namespace
}  // namespace tagcal
