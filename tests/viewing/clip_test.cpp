#include "tagcal/viewing/clip.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tagcal/random.hpp"
#include "tagcal/viewing/canonical.hpp"

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
      const auto parts = clip_to_domain(triangle, lens, 1e-6);
      for (const auto& part : parts)
        for (const Vector3d& x : part) EXPECT_TRUE(in_domain(lens, x));
      kept += !parts.empty();
    }
    EXPECT_GT(kept, 30);
  }
}

// Area of a polygon in space.
double area(const std::vector<Vector3d>& polygon) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  return sum.norm() / 2;
}

TEST(ClipToDomain, AWideFisheyeLosesOnlyTheConeBehindIt) {
  // A square wall 1 m behind the camera; the fisheye sees up to 135 degrees, all but a disc of
  // radius 1 m around the backward axis.
  const double k1 = -1 / (3 * std::pow(0.75 * std::numbers::pi, 2));  // fold: 1 + 3 k1 a^2 = 0
  const Fisheye lens({300, 300, 0, 0, k1, 0, 0, 0});
  ASSERT_NEAR(lens.max_angle(), 0.75 * std::numbers::pi, 1e-9);
  const std::vector<Vector3d> wall = {{-3, -3, -1}, {3, -3, -1}, {3, 3, -1}, {-3, 3, -1}};
  const auto parts = clip_to_domain(wall, lens, 1e-6);
  double sum = 0;
  for (const auto& part : parts) {
    sum += area(part);
    for (const Vector3d& x : part) EXPECT_TRUE(in_domain(lens, x));
  }
  EXPECT_NEAR(sum, 36 - std::numbers::pi, 1e-3);  // the disc as a 256-gon around it
  EXPECT_EQ(clip_to_domain({{2, -1, -1}, {3, -1, -1}, {3, 1, -1}}, lens, 1e-6).size(), 1u);
  EXPECT_TRUE(clip_to_domain({{0, -.1, -1}, {.1, .1, -1}, {-.1, .1, -1}}, lens, 1e-6).empty());
}

Eigen::Matrix4d usual_clip_matrix() {
  return clip_from_eye({Projection::perspective, {-0.3, 0.5, -0.2, 0.4}, 0.6, 2});
}

TEST(ClipPlanes, AreThoseOfTheFrustum) {
  const auto planes = clip_planes(usual_clip_matrix());
  ASSERT_EQ(planes.size(), 6u);
  EXPECT_NEAR(planes[4].height({0, 0, -1}), 0.4, 1e-15);  // near, at 0.6
  EXPECT_NEAR(planes[5].height({0, 0, -1}), 1, 1e-15);    // far, at 2
  EXPECT_NEAR(planes[0].height({-0.3, 0, -0.6}), 0, 1e-15);
  EXPECT_NEAR(planes[3].height({0, 0.4, -0.6}), 0, 1e-15);
  ViewVolume endless{Projection::perspective, {-0.3, 0.5, -0.2, 0.4}, 0.6, 2};
  endless.far_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(clip_planes(clip_from_eye(endless)).size(), 5u);
}

TEST(ClipPlanes, ContainWhatIsInTheCanonicalVolume) {
  const Eigen::Matrix4d m = usual_clip_matrix();
  const auto planes = clip_planes(m);
  Random random(5);
  int inside = 0;
  for (int i = 0; i < 10000; ++i) {
    const Vector3d x(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-3, 1));
    EXPECT_EQ(contains(planes, x), in_clip_volume(m * x.homogeneous()));
    inside += contains(planes, x);
  }
  EXPECT_GT(inside, 100);
}

TEST(ClipSegment, KeepsThePartInTheFrustum) {
  const auto planes = clip_planes(usual_clip_matrix());
  Random random(6);
  int cut = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d a(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 1));
    const Vector3d b(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 1));
    const auto part = clip_segment(a, b, planes);
    for (int k = 0; k <= 50; ++k) {
      const double t = k / 50.0;
      const bool inside = contains(planes, a + t * (b - a));
      const bool kept = part && t > part->from + 1e-12 && t < part->to - 1e-12;
      const bool left_out = !part || t < part->from - 1e-12 || t > part->to + 1e-12;
      EXPECT_TRUE(inside || !kept);
      EXPECT_FALSE(inside && left_out);
    }
    cut += part && (part->from > 0 || part->to < 1);
  }
  EXPECT_GT(cut, 300);
  EXPECT_FALSE(clip_segment({std::nan(""), 0, -1}, {0, 0, -1}, planes));
}

TEST(ClipPolygon, AgainstTheSixPlanesAndInClipCoordinates) {
  const Eigen::Matrix4d m = usual_clip_matrix();
  const auto planes = clip_planes(m);
  Random random(7);
  int behind = 0;
  for (int i = 0; i < 1000; ++i) {
    std::vector<Vector3d> triangle;
    std::vector<Eigen::Vector4d> in_clip;
    for (int k = 0; k < 3; ++k) {
      triangle.emplace_back(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-3, 2));
      in_clip.push_back(m * triangle.back().homogeneous());
    }
    const auto in_space = clip_polygon(triangle, planes);
    const auto homogeneous = clip_polygon_to_volume(in_clip);
    ASSERT_EQ(in_space.empty(), homogeneous.empty());
    std::vector<Vector3d> back;
    for (const Eigen::Vector4d& x : homogeneous) {
      EXPECT_GT(x.w(), 0);
      back.push_back((m.inverse() * x).hnormalized());
    }
    EXPECT_NEAR(area(in_space), area(back), 1e-12);
    behind += !in_space.empty() && std::ranges::any_of(triangle, [](auto& x) { return x.z() > 0; });
  }
  EXPECT_GT(behind, 50);  // some reach behind the eye
}

TEST(SegmentPlane, MeetsOnceOrNotAtAll) {
  const HalfSpace plane{Vector3d::UnitZ(), 2};
  EXPECT_EQ(segment_plane_intersection({0, 0, 0}, {4, 8, 4}, plane), Vector3d(2, 4, 2));
  EXPECT_EQ(segment_plane_intersection({0, 0, 2}, {0, 0, 5}, plane), Vector3d(0, 0, 2));
  EXPECT_FALSE(segment_plane_intersection({0, 0, 0}, {1, 0, 1.9}, plane));  // too short
  EXPECT_FALSE(segment_plane_intersection({0, 0, 1}, {1, 0, 1}, plane));    // parallel
  EXPECT_FALSE(segment_plane_intersection({0, 0, 2}, {1, 0, 2}, plane));    // in the plane
  EXPECT_FALSE(segment_plane_intersection({0, 0, std::nan("")}, {1, 0, 2}, plane));
}

TEST(BackFace, TurnsClockwise) {
  EXPECT_FALSE(is_back_face(kSquare, {0.5, 0.5, 3}));
  EXPECT_TRUE(is_back_face(kSquare, {0.5, 0.5, -3}));
  EXPECT_TRUE(is_back_face(kSquare, {5, 0, 1}));  // on edge
}

}  // namespace
}  // namespace tagcal
