#include "tagcal/solvers/plane.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <vector>

#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTrials = 10000;

struct Plane {
  std::vector<Vector2d> points;
  std::vector<Vector3d> rays;
  Pose pose;
};

std::vector<Vector2d> in_plane(const std::vector<Vector3d>& points) {
  std::vector<Vector2d> result;
  for (const Vector3d& p : points) result.push_back(p.head<2>());
  return result;
}

// Rays of any length, noise in radians.
Plane seen_plane(const std::vector<Vector2d>& points, const Pose& pose, double sigma,
                 Random& random) {
  Plane plane{points, {}, pose};
  for (const Vector2d& p : points) {
    const Vector3d x = pose * Vector3d(p.x(), p.y(), 0);
    plane.rays.push_back(
        random.uniform(0.1, 10) *
        (x.normalized() + sigma * Vector3d(random.normal(), random.normal(), random.normal())));
  }
  return plane;
}

Matrix3d homography_of(const Pose& pose) {
  Matrix3d h;
  h << pose.rotation_matrix().leftCols<2>(), pose.translation();
  return h;
}

// Largest angle between the image of a point and its ray; pi if the point lies behind.
double largest_angle(const Matrix3d& h, const Plane& plane) {
  double largest = 0;
  for (std::size_t i = 0; i < plane.points.size(); ++i) {
    const Vector3d image = h * plane.points[i].homogeneous();
    largest =
        std::max(largest, std::atan2(image.cross(plane.rays[i]).norm(), image.dot(plane.rays[i])));
  }
  return largest;
}

// Random pose that sees the front or the back of points of about unit size, tilted by up to 75
// degrees.
Pose any_pose(Random& random, double distance) {
  const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0, 1.3), distance, random);
  if (random.index(2) == 0) return pose;
  return pose * Pose(exp_rotation({std::numbers::pi, 0, 0}), {0, 0, 0});
}

TEST(Homography, IsExactForFourPoints) {
  Random random(1);
  for (int i = 0; i < kTrials; ++i) {
    const auto points =
        i % 2 == 0 ? in_plane(tag_points(1)) : in_plane(points_in_box(4, 1, 0, random));
    const Plane plane = seen_plane(points, any_pose(random, 3), 0, random);
    const auto h = homography(plane.points, plane.rays);
    if (!h) continue;
    EXPECT_LT(largest_angle(*h, plane), 1e-9) << i;
    if (i % 2 == 0) {
      const Matrix3d truth = homography_of(plane.pose);
      EXPECT_LT((*h / h->norm() - truth / truth.norm()).norm(), 1e-12) << i;
    }
  }
}

TEST(Homography, OfATagIsAlwaysFound) {
  Random random(2);
  for (int i = 0; i < kTrials; ++i) {
    const double size = std::pow(10.0, random.uniform(-9, 9));
    Pose pose = any_pose(random, 3);
    pose = Pose(pose.rotation(), size * pose.translation());
    const Plane plane = seen_plane(in_plane(tag_points(size)), pose, 0, random);
    const auto h = homography(plane.points, plane.rays);
    ASSERT_TRUE(h) << size;
    EXPECT_LT(largest_angle(*h, plane), 1e-12) << size;
  }
}

TEST(Homography, IsExactForManyPoints) {
  Random random(3);
  for (int i = 0; i < kTrials / 10; ++i) {
    const double size = std::pow(10.0, random.uniform(-6, 6));
    const int n = 5 + static_cast<int>(random.index(60));
    std::vector<Vector2d> points = in_plane(points_in_box(n, size, 0, random));
    // Not about the origin: the pose looks at the points.
    const Vector2d offset = (i % 2 == 0 ? 0 : 100 * size) * Vector2d(1, -1);
    for (Vector2d& p : points) p += offset;
    Pose pose = any_pose(random, 3);
    pose = Pose(pose.rotation(),
                size * pose.translation() - pose.rotation() * Vector3d(offset.x(), offset.y(), 0));
    const Plane plane = seen_plane(points, pose, 0, random);
    const auto h = homography(plane.points, plane.rays);
    ASSERT_TRUE(h) << n;
    EXPECT_LT(largest_angle(*h, plane), 1e-9) << n << " " << size;
  }
}

// A wall beside the camera, and one behind: rays anywhere in a half space.
TEST(Homography, RaysBeyond90DegreesAreNoException) {
  Random random(4);
  for (int i = 0; i < kTrials / 10; ++i) {
    const Pose pose = Pose(random_rotation(random), Vector3d::Zero()) * any_pose(random, 3);
    for (const int n : {4, 12}) {
      const auto points =
          n == 4 ? in_plane(tag_points(2)) : in_plane(points_in_box(n, 1, 0, random));
      const Plane plane = seen_plane(points, pose, 0, random);
      const auto h = homography(plane.points, plane.rays);
      ASSERT_TRUE(h) << n;
      EXPECT_LT(largest_angle(*h, plane), 1e-10) << n;
    }
  }
}

TEST(Homography, NoiseMovesItLittle) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Plane plane =
        seen_plane(in_plane(points_in_box(40, 1, 0, random)),
                   looking_at_board(Vector3d::Zero(), 0.6, 3, random), 1e-3, random);
    const auto h = homography(plane.points, plane.rays);
    ASSERT_TRUE(h);
    EXPECT_LT(largest_angle(*h, plane), 6e-3);
    const Matrix3d truth = homography_of(plane.pose);
    EXPECT_LT((*h / h->norm() - truth / truth.norm()).norm(), 0.01);
  }
}

TEST(Homography, PointsOnALineFixNone) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const Vector2d a(random.normal(), random.normal()), b(random.normal(), random.normal());
    std::vector<Vector2d> points;
    const auto count = static_cast<std::size_t>(4 + 4 * (i % 2));
    while (points.size() < count) points.push_back(a + random.uniform(-1, 1) * b);
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 20, random);
    Plane plane = seen_plane(points, pose, 0, random);
    EXPECT_FALSE(homography(plane.points, plane.rays)) << i;
    // Three of four points on a line.
    points.resize(4);
    points[random.index(4)] = {random.normal(), random.normal()};
    plane = seen_plane(points, pose, 0, random);
    EXPECT_FALSE(homography(plane.points, plane.rays)) << i;
    points[0] = points[1];
    plane = seen_plane(points, pose, 0, random);
    EXPECT_FALSE(homography(plane.points, plane.rays)) << i;
  }
}

// A crossed quadrilateral, or one corner inside the triangle of the others, is no image of a tag.
TEST(Homography, PointsThatCannotBeInFrontHaveNone) {
  const auto tag = in_plane(tag_points(1));
  const std::vector<Vector3d> square = {{-1, -1, 4}, {1, -1, 4}, {1, 1, 4}, {-1, 1, 4}};
  EXPECT_TRUE(homography(tag, square));
  const std::vector<Vector3d> crossed = {square[1], square[0], square[2], square[3]};
  EXPECT_FALSE(homography(tag, crossed));
  const std::vector<Vector3d> inside = {{-1, -1, 4}, {1, -1, 4}, {0, -0.5, 4}, {-1, 1, 4}};
  EXPECT_FALSE(homography(tag, inside));
  const std::vector<Vector3d> behind = {square[0], square[1], -square[2], square[3]};
  EXPECT_FALSE(homography(tag, behind));
}

TEST(Homography, NeedsFourAndNumbers) {
  const auto tag = in_plane(tag_points(1));
  std::vector<Vector3d> rays = {{-1, -1, 4}, {1, -1, 4}, {1, 1, 4}, {-1, 1, 4}};
  EXPECT_FALSE(homography({}, {}));
  EXPECT_FALSE(homography({tag.data(), 3}, {rays.data(), 3}));
  rays[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(homography(tag, rays));
  const std::vector<Vector3d> same(4, Vector3d(0, 0, 1));
  EXPECT_FALSE(homography(tag, same));
  const std::vector<Vector2d> one(6, Vector2d(1, 2));
  const std::vector<Vector3d> six(6, Vector3d(0, 0, 1));
  EXPECT_FALSE(homography(one, six));
}

double error_of(const Pose& pose, const Pose& truth) {
  return angle_between_rad(pose, truth) +
         distance_between_m(pose, truth) / truth.translation().norm();
}

void expect_poses_with_truth(const Pose& truth, double tolerance) {
  const Solutions<Pose, 2> poses = ippe(homography_of(truth));
  ASSERT_EQ(poses.size(), 2u);
  double least = 10;
  for (const Pose& pose : poses) {
    ASSERT_TRUE(pose.matrix().allFinite());
    ASSERT_NEAR(pose.rotation_matrix().determinant(), 1, 1e-12);
    ASSERT_NEAR(pose.rotation().norm(), 1, 1e-12);
    least = std::min(least, error_of(pose, truth));
  }
  EXPECT_LT(least, tolerance) << truth.matrix();
}

TEST(Ippe, HoldsTheTruthForAnyPose) {
  Random random(7);
  for (int i = 0; i < kTrials; ++i) {
    const double size = std::pow(10.0, random.uniform(-9, 9));
    const Pose pose = any_pose(random, 2);
    const Pose anywhere = Pose(random_rotation(random), Vector3d::Zero()) *
                          Pose(pose.rotation(), size * pose.translation());
    // Near frontal the tilt is the root of a difference and loses half of the digits.
    expect_poses_with_truth(anywhere, 1e-6);
  }
}

TEST(Ippe, FrontalPlanesHaveTheirPoses) {
  Random random(8);
  for (const double tilt : {0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3}) {
    for (int i = 0; i < kTrials / 10; ++i) {
      const Vector3d half_turn[3] = {{std::numbers::pi, 0, 0}, {0, std::numbers::pi, 0}, {0, 0, 0}};
      const Pose facing(exp_rotation(half_turn[random.index(3)]), Vector3d::Zero());
      const double roll = i % 4 == 0 ? 0 : random.uniform(-4, 4);
      const double turn = random.uniform(0, 7);
      const Pose tilted(exp_rotation(tilt * Vector3d(std::cos(turn), std::sin(turn), 0)) *
                            exp_rotation({0, 0, roll}),
                        Vector3d(0, 0, random.uniform(0.1, 10)));
      expect_poses_with_truth(tilted * facing, 1e-7);
    }
  }
}

// Rotations by 180 degrees about any axis, as of a tag that faces the camera.
TEST(Ippe, HalfTurnsAreNoException) {
  Random random(9);
  for (int i = 0; i < kTrials / 10; ++i) {
    const Vector3d axis =
        Vector3d(random.normal(), random.normal(), i % 2 == 0 ? 0 : 0.3 * random.normal());
    const double angle = std::numbers::pi - std::array{0.0, 1e-15, 1e-9, 1e-4}[random.index(4)];
    expect_poses_with_truth(Pose(exp_rotation(angle * axis.normalized()), {0.1, -0.2, 1}), 1e-6);
  }
}

TEST(Ippe, BothPosesAgreeWithTheImageAboutTheOrigin) {
  Random random(10);
  for (int i = 0; i < 1000; ++i) {
    const Pose truth = looking_at_board(Vector3d::Zero(), random.uniform(0.3, 1), 2, random);
    const Solutions<Pose, 2> poses = ippe(homography_of(truth));
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_GT(angle_between_rad(poses[0], poses[1]), 0.1);
    for (const Pose& pose : poses)
      for (const Vector3d& x : {Vector3d(0, 0, 0), Vector3d(1e-5, 0, 0), Vector3d(0, 1e-5, 0)})
        EXPECT_LT(((pose * x).normalized() - (truth * x).normalized()).norm(), 1e-9);
  }
}

TEST(Ippe, RefusesWhatIsNoHomography) {
  EXPECT_TRUE(ippe(Matrix3d::Zero()).empty());
  Matrix3d flat = homography_of(Pose(exp_rotation({0.5, 0, 0}), {0, 0, 1}));
  flat.col(1) = 2 * flat.col(0);
  for (const Pose& pose : ippe(flat)) EXPECT_TRUE(pose.matrix().allFinite());
  Matrix3d line = Matrix3d::Zero();
  line.col(2) = Vector3d(0, 0, 1);
  EXPECT_TRUE(ippe(line).empty());
  for (Eigen::Index k = 0; k < 9; ++k)
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Matrix3d h = homography_of(Pose(exp_rotation({0.5, 0.1, 0}), {0, 0, 1}));
      h(k / 3, k % 3) = bad;
      EXPECT_TRUE(ippe(h).empty()) << k << " " << bad;
    }
}

// For noise, random matrices and huge numbers the solvers return rotations or nothing.
TEST(Ippe, NeverGivesNaN) {
  Random random(11);
  for (int i = 0; i < kTrials; ++i) {
    Matrix3d h;
    for (Eigen::Index k = 0; k < 9; ++k)
      h(k / 3, k % 3) =
          random.normal() * std::pow(10.0, i % 3 == 0 ? random.uniform(-150, 150) : 0);
    for (const Pose& pose : ippe(h)) {
      ASSERT_TRUE(pose.matrix().allFinite()) << h;
      ASSERT_NEAR(pose.rotation_matrix().determinant(), 1, 1e-9) << h;
    }
  }
}

TEST(FocalRatio, ComesFromPlanesThatAreTilted) {
  Random random(12);
  for (int i = 0; i < 1000; ++i) {
    const double ratio = std::pow(10.0, random.uniform(-1, 1));
    std::vector<Matrix3d> homographies;
    for (std::size_t k = 0; k < 1 + random.index(5); ++k) {
      const Matrix3d h =
          homography_of(looking_at_board(Vector3d::Zero(), random.uniform(0.3, 1), 1, random));
      homographies.emplace_back(random.uniform(0.01, 100) *
                                (Vector3d(ratio, ratio, 1).asDiagonal() * h));
    }
    const auto found = focal_ratio_from_homographies(homographies);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found / ratio, 1, 1e-10);
  }
}

TEST(FocalRatio, NotFromFrontalOnes) {
  Random random(13);
  for (int i = 0; i < 1000; ++i) {
    const Pose frontal(exp_rotation({0, 0, random.uniform(-3, 3)}),
                       {random.normal(), random.normal(), 3});
    const Matrix3d h = homography_of(frontal);
    const auto ratio = focal_ratio_from_homographies({&h, 1});
    EXPECT_FALSE(ratio.has_value()) << *ratio;
  }
  EXPECT_FALSE(focal_ratio_from_homographies({}));
}

TEST(PoseFromHomography, IsExact) {
  Random random(14);
  for (int i = 0; i < kTrials; ++i) {
    const Pose pose = Pose(random_rotation(random), Vector3d::Zero()) * any_pose(random, 2);
    const Matrix3d h = random.uniform(0.01, 100) * homography_of(pose);
    EXPECT_LT(error_of(pose_from_homography(h), pose), 1e-12);
  }
}

TEST(PlanePoseAndFocal, IsExactWhereThePlaneIsTilted) {
  Random random(15);
  for (int i = 0; i < kTrials / 5; ++i) {
    const double focal = std::pow(10.0, random.uniform(2, 4));
    const double size = std::pow(10.0, random.uniform(-6, 6));
    const int n = i % 2 == 0 ? 4 : 30;
    const auto points =
        n == 4 ? in_plane(tag_points(size)) : in_plane(points_in_box(n, size / 2, 0, random));
    Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.3, 1), 2, random);
    pose = Pose(pose.rotation(), size * pose.translation());
    std::vector<Vector2d> pixels;
    for (const Vector2d& p : points)
      pixels.push_back(focal * (pose * Vector3d(p.x(), p.y(), 0)).hnormalized());
    const auto found = plane_pose_and_focal(points, pixels);
    ASSERT_TRUE(found) << i;
    EXPECT_NEAR(found->focal_px / focal, 1, 1e-9) << i;
    EXPECT_LT(error_of(found->camera_from_target, pose), 1e-9) << i;
    EXPECT_NEAR(found->camera_from_target.rotation_matrix().determinant(), 1, 1e-12);
  }
}

TEST(PlanePoseAndFocal, FrontalPlanesAndOnePlaceHaveNone) {
  Random random(16);
  const auto tag = in_plane(tag_points(0.1));
  for (int i = 0; i < 100; ++i) {
    const Pose pose(exp_rotation({0, 0, random.uniform(-3, 3)}), {0.1, 0.2, 1});
    std::vector<Vector2d> pixels;
    for (const Vector2d& p : tag)
      pixels.push_back(900 * (pose * Vector3d(p.x(), p.y(), 0)).hnormalized());
    const auto found = plane_pose_and_focal(tag, pixels);
    if (found) {  // rounding causes a tilt
      EXPECT_TRUE(found->camera_from_target.matrix().allFinite() && found->focal_px > 0);
    }
  }
  EXPECT_FALSE(plane_pose_and_focal(tag, std::vector<Vector2d>(4, Vector2d(0, 0))));
  EXPECT_FALSE(plane_pose_and_focal(tag, std::vector<Vector2d>(4, Vector2d(50, 30))));
  EXPECT_FALSE(plane_pose_and_focal({}, {}));
}

}  // namespace
}  // namespace tagcal
