#include "tagcal/viewing/projection.hpp"

#include <gtest/gtest.h>

#include "poses.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d image_of(const Matrix4d& projection, const Vector3d& x) {
  return divided(projection * x.homogeneous()).value();
}

Vector3d random_point_in_front(Random& random) {
  return {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0.1, 10)};
}

TEST(PerspectiveProjection, DividesByDepthOverTheDistanceOfThePlane) {
  EXPECT_TRUE(image_of(perspective_from_origin(2), {3, -4, 8}).isApprox(Vector3d(0.75, -1, 2)));
  EXPECT_TRUE(image_of(perspective_from_behind(2), {3, -4, 6}).isApprox(Vector3d(0.75, -1, 0)));
}

TEST(PerspectiveProjection, BothCentresGiveTheSamePictureOfAMovedWorld) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d x = random_point_in_front(random);
    const double d = random.uniform(0.1, 10);
    const Vector3d from_origin = image_of(perspective_from_origin(d), x);
    const Vector3d from_behind = image_of(perspective_from_behind(d), x - Vector3d(0, 0, d));
    EXPECT_LT((from_origin.head<2>() - from_behind.head<2>()).norm(), 1e-13 * from_origin.norm());
    EXPECT_EQ(from_behind.z(), 0);
    EXPECT_NEAR(from_origin.z(), d, 1e-15 * d);
  }
}

TEST(PerspectiveProjection, TendsToTheOrthographicOneAsTheCentreMovesAway) {
  EXPECT_EQ(perspective_from_behind(kInfinity), orthographic_projection());
  const Vector3d x(1, -2, 3);
  const Vector3d limit = image_of(orthographic_projection(), x);
  EXPECT_EQ(limit, Vector3d(1, -2, 0));
  double before = kInfinity;
  for (const double d : {1e1, 1e3, 1e5, 1e7}) {
    const double off = (image_of(perspective_from_behind(d), x) - limit).norm();
    EXPECT_NEAR(off, limit.norm() * 3 / (d + 3), 1e-15);  // 1 - 1 / (z/d + 1)
    EXPECT_LT(off, before);
    before = off;
  }
}

TEST(PerspectiveProjection, HasNoImageBesideAndBehindTheCentre) {
  EXPECT_FALSE(divided(perspective_from_origin(1) * Vector3d(1, 1, 0).homogeneous()));
  EXPECT_FALSE(divided(perspective_from_origin(1) * Vector3d(1, 1, -1).homogeneous()));
  EXPECT_FALSE(divided(Eigen::Vector4d::Constant(std::nan(""))));
}

TEST(PerspectiveProjection, RefusesAPlaneThatIsNone) {
  for (const double d : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(perspective_from_origin(d), Error);
    EXPECT_THROW(perspective_from_behind(d), Error);
  }
  EXPECT_THROW(perspective_from_origin(kInfinity), Error);
}

TEST(ObliqueProjection, CavalierKeepsDepthAndCabinetHalvesIt) {
  for (const double angle : {0.0, kPi / 6, kPi / 4, 2.0}) {
    const Vector2d recedes(std::cos(angle), -std::sin(angle));  // up and right on the page
    const Vector3d further(0, 0, 1);
    EXPECT_TRUE(image_of(cavalier_projection(angle), further).head<2>().isApprox(recedes, 1e-15));
    EXPECT_TRUE(
        image_of(cabinet_projection(angle), further).head<2>().isApprox(recedes / 2, 1e-15));
    // The front face keeps its shape.
    EXPECT_EQ(image_of(cabinet_projection(angle), {0.3, 0.4, 0}), Vector3d(0.3, 0.4, 0));
  }
}

TEST(ObliqueProjection, RaysMeetThePlaneAt45DegreesAndAtArctan2) {
  const auto angle_to_plane = [](const Matrix4d& projection) {
    const Vector3d ray = image_of(projection, {0, 0, 1}) - Vector3d(0, 0, 1);
    return std::asin(std::abs(ray.z()) / ray.norm());
  };
  EXPECT_NEAR(angle_to_plane(cavalier_projection(1)), kPi / 4, 1e-15);
  EXPECT_NEAR(angle_to_plane(cabinet_projection(1)), std::atan(2), 1e-15);
}

TEST(ObliqueProjection, GoesAlongItsDirection) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d x = random_point_in_front(random);
    const Vector3d direction(random.normal(), random.normal(), random.normal());
    const Vector3d image = image_of(oblique_projection(direction), x);
    EXPECT_EQ(image.z(), 0);
    EXPECT_LT((image - x).cross(direction).norm(), 1e-12 * (image - x).norm() * direction.norm());
  }
  EXPECT_EQ(oblique_projection({0, 0, -3}), orthographic_projection());
  EXPECT_THROW(oblique_projection({1, 2, 0}), Error);
  EXPECT_THROW(oblique_projection({0, 0, 0}), Error);
  EXPECT_THROW(oblique_projection({0, 0, std::nan("")}), Error);
}

// On the page x is right and y up; the camera's y is down.
Vector2d on_page(DrawnView view, const Vector3d& x_in_world) {
  const Vector3d x = camera_from_world_drawn(view) * x_in_world;
  return Vector2d(x.x(), -x.y());
}

TEST(DrawnViews, PlanElevationsAndSide) {
  const Vector3d x(1, 2, 3);
  EXPECT_TRUE(on_page(DrawnView::plan, x).isApprox(Vector2d(1, 2), 1e-15));
  EXPECT_TRUE(on_page(DrawnView::front_elevation, x).isApprox(Vector2d(1, 3), 1e-15));
  EXPECT_TRUE(on_page(DrawnView::side_elevation, x).isApprox(Vector2d(2, 3), 1e-15));
  // What is nearer to the viewer: the top, the front (smaller y), the right.
  EXPECT_LT((camera_from_world_drawn(DrawnView::plan) * x).z(), 0);
  EXPECT_GT((camera_from_world_drawn(DrawnView::front_elevation) * x).z(), 0);
  EXPECT_LT((camera_from_world_drawn(DrawnView::side_elevation) * x).z(), 0);
}

TEST(DrawnViews, IsometricShowsTheThreeAxesAlike) {
  const Vector2d x = on_page(DrawnView::isometric, Vector3d::UnitX());
  const Vector2d y = on_page(DrawnView::isometric, Vector3d::UnitY());
  const Vector2d z = on_page(DrawnView::isometric, Vector3d::UnitZ());
  for (const Vector2d& axis : {x, y, z}) EXPECT_NEAR(axis.norm(), std::sqrt(2.0 / 3), 1e-15);
  const double at_120 = -0.5 * 2 / 3;  // cos 120 times the lengths
  EXPECT_NEAR(x.dot(z), at_120, 1e-15);
  EXPECT_NEAR(x.dot(-y), at_120, 1e-15);  // y runs away from the viewer
  EXPECT_NEAR(z.dot(-y), at_120, 1e-15);
  EXPECT_TRUE(z.isApprox(Vector2d(0, std::sqrt(2.0 / 3)), 1e-15));
}

TEST(VanishingPoints, OneTwoAndThreePointPerspective) {
  const Lens lens = pinhole(800, 800, 320, 240);
  const auto turned = [](double yaw, double pitch) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(pitch, Vector3d::UnitX()) *
                              Eigen::AngleAxisd(yaw, Vector3d::UnitY()));
  };
  EXPECT_EQ(num_vanishing_axes(lens, turned(0, 0)), 1);
  EXPECT_EQ(num_vanishing_axes(lens, turned(0.5, 0)), 2);
  EXPECT_EQ(num_vanishing_axes(lens, turned(0.5, 0.3)), 3);
  EXPECT_EQ(num_vanishing_axes(lens, turned(kPi / 2, 0)), 1);  // to rounding
  EXPECT_EQ(num_vanishing_axes(Parallel({1, 1, 0, 0}), turned(0.5, 0.3)), 0);
}

TEST(VanishingPoints, AreWhereLinesEnd) {
  const Perspective lens({800, 790, 320, 240, -0.2, 0.05, 1e-3, -1e-3, 0.01, 0, 0, 0});
  const Vector3d direction(0.2, -0.1, -1);
  const auto points = vanishing_points(lens, direction);
  ASSERT_EQ(points.size(), 1u);
  const auto far = lens.project(Vector3d(3, 4, 5) - 1e9 * direction);
  EXPECT_LT((points[0] - *far).norm(), 1e-5);
  EXPECT_EQ(vanishing_points(lens, -direction), points);
  EXPECT_TRUE(vanishing_points(lens, {1, 0, 0}).empty());
}

TEST(VanishingPoints, AFisheyeHasOneEachWay) {
  const Fisheye lens({300, 300, 640, 400, 0, 0, 0, 0});
  const auto points = vanishing_points(lens, Vector3d::UnitX());
  ASSERT_EQ(points.size(), 2u);
  EXPECT_NEAR(points[0].x(), 640 + 300 * kPi / 2, 1e-9);
  EXPECT_NEAR(points[1].x(), 640 - 300 * kPi / 2, 1e-9);
}

TEST(Projection, ThePerspectiveMapKeepsPlanesAndTheOrderOfDepths) {
  const auto image = [](const Eigen::Vector3d& x) {
    return *divided(perspective_map() * x.homogeneous());
  };
  EXPECT_TRUE(image({2, 3, 4}).isApprox(Eigen::Vector3d(0.5, 0.75, 0.25), 1e-15));
  const Eigen::Vector3d o(1, 2, 5), u(1, 0, 2), v(0.5, -1, 1);
  const Eigen::Vector3d a = image(o), b = image(o + u), c = image(o + v), d = image(o + u + v);
  EXPECT_LT(std::abs((b - a).cross(c - a).dot(d - a)), 1e-16);
  EXPECT_GT(image({0, 0, 1}).z(), image({0, 0, 2}).z());
}

}  // namespace
}  // namespace tagcal
