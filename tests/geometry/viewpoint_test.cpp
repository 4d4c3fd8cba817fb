#include "tagcal/geometry/viewpoint.hpp"

#include <gtest/gtest.h>

#include "expect.hpp"
#include "poses.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A camera that looks along -z, moved from the origin to z = -3, sees of a unit square at z = -10
// what the camera at the origin sees of a world moved by +3, the square at z = -7.
TEST(LookingAt, AMovedCameraSeesWhatAMovedWorldShows) {
  const Pose at_origin = camera_from_world_looking_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0});
  const Pose moved = camera_from_world_looking_at({0, 0, -3}, {0, 0, -4}, {0, 1, 0});
  expect_same(moved, at_origin * translation({0, 0, 3}));
  for (const Vector3d& corner : {Vector3d(0, 0, -10), Vector3d(1, 0, -10), Vector3d(1, 1, -10)}) {
    EXPECT_LT((moved * corner - Vector3d(corner.x(), -corner.y(), 7)).norm(), 1e-14);
    EXPECT_LT((moved * corner - at_origin * (corner + Vector3d(0, 0, 3))).norm(), 1e-14);
  }
}

TEST(LookingAt, ThereAndBack) {
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Vector3d eye = random_vector(random), target = random_vector(random);
    const Pose pose = camera_from_world_looking_at(eye, target, random_vector(random));
    const LookAt back = look_at(pose, (target - eye).norm());
    EXPECT_LT((back.eye - eye).norm(), 4e-15 * (1 + eye.norm()));
    EXPECT_LT((back.target - target).norm(), 1e-14);
    expect_same(camera_from_world_looking_at(back.eye, back.target, back.up), pose, 1e-14);
  }
}

TEST(LookingAt, ParallelUpNoViewAndNoNumbersAreErrors) {
  EXPECT_THROW(camera_from_world_looking_at({0, 0, 1}, {0, 0, 0}, {0, 0, -2}), Error);
  EXPECT_THROW(camera_from_world_looking_at({0, 0, 1}, {0, 0, 0}, {0, 0, 0}), Error);
  EXPECT_THROW(camera_from_world_looking_at({1, 2, 3}, {1, 2, 3}, {0, 0, 1}), Error);
  EXPECT_ERROR(camera_from_world_looking_at({1, 2, 3}, {1, 2, kNan}, {0, 0, 1}),
               "look-at: must be finite");
  EXPECT_THROW(camera_from_world_looking_at({1, 2, 3}, {1, 2, 5}, {0, kNan, 1}), Error);
  EXPECT_THROW(look_at(Pose(), 0), Error);
  EXPECT_THROW(look_at(Pose(), kNan), Error);
  EXPECT_THROW(look_at(kBadPose, 1), Error);
}

// A world with y down: moved to the eye, turned about y and then about x so that the view is along
// z, and about z if the camera is rolled.
TEST(LookingAt, IsAMoveAndTwoTurnsAndAThirdIfRolled) {
  const Vector3d eye(1, -2, 3);
  const Pose turned = rotation_about_x(0.4) * rotation_about_y(-1.1) * translation(-eye);
  const Vector3d target = turned.inverse() * Vector3d(0, 0, 2);
  const Pose upright = camera_from_world_looking_at(eye, target, {0, -1, 0});
  EXPECT_LT((upright.matrix() - turned.matrix()).norm(), 4e-15);
  const Pose rolled = rotation_about_z(0.3) * turned;
  const Vector3d up = rolled.inverse().rotation() * Vector3d(0, -1, 0);
  const Pose looking = camera_from_world_looking_at(eye, target, up);
  EXPECT_LT((looking.matrix() - rolled.matrix()).norm(), 4e-15);
}

TEST(CameraAxes, GiveThePoseAndThePoseGivesThem) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Pose world_from_camera = random_pose(random);
    expect_same(camera_from_world_with_axes(world_from_camera.rotation_matrix(),
                                            world_from_camera.translation()),
                world_from_camera.inverse());
  }
}

TEST(CameraAxes, RoundedOnesBecomeTheNearestRotation) {
  // 45 degrees about z, to three digits
  Matrix3d axes;
  axes << 0.707, -0.707, 0, 0.707, 0.707, 0, 0, 0, 1;
  expect_same(camera_from_world_with_axes(axes, Vector3d::Zero()), rotation_about_z(-kPi / 4));
}

TEST(CameraAxes, FarOffLeftHandedAndFlatOnesAreErrors) {
  Matrix3d axes = Matrix3d::Identity();
  axes(0, 1) = 0.9e-3 / std::sqrt(2.0);  // |A'A - 1| is 0.9e-3, then 1.1e-3
  EXPECT_NO_THROW(camera_from_world_with_axes(axes, Vector3d::Zero()));
  axes(0, 1) = 1.1e-3 / std::sqrt(2.0);
  EXPECT_THROW(camera_from_world_with_axes(axes, Vector3d::Zero()), Error);
  EXPECT_THROW(camera_from_world_with_axes(-Matrix3d::Identity(), Vector3d::Zero()), Error);
  EXPECT_THROW(camera_from_world_with_axes(Matrix3d::Zero(), Vector3d::Zero()), Error);
  EXPECT_THROW(camera_from_world_with_axes(Matrix3d::Constant(kNan), Vector3d::Zero()), Error);
  EXPECT_THROW(camera_from_world_with_axes(Matrix3d::Identity(), {0, 0, kNan}), Error);
}

TEST(Orbit, IsTheLookAtOfAnUprightCamera) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Orbit orbit{random_vector(random), random.uniform(0.5, 5), random.uniform(-kPi, kPi),
                random.uniform(-1.5, 1.5), 0};
    const Vector3d eye =
        orbit.target + cartesian_from_spherical(
                           {orbit.distance_m, kPi / 2 - orbit.elevation_rad, orbit.azimuth_rad});
    const Pose upright = camera_from_world_looking_at(eye, orbit.target, Vector3d::UnitZ());
    expect_same(camera_from_world_on_orbit(orbit), upright, 2e-14);
    // What is to the right in the image turns clockwise: down.
    orbit.twist_rad = kPi / 2;
    const Pose twisted = camera_from_world_on_orbit(orbit);
    const Vector3d right_in_world = upright.inverse().rotation() * Vector3d::UnitX();
    EXPECT_LT((twisted.rotation() * right_in_world - Vector3d::UnitY()).norm(), 1e-14);
  }
}

TEST(Orbit, StraightDownTheAzimuthSaysWhatIsUp) {
  for (const double azimuth : {0.0, 0.5, -2.5}) {
    const Pose down = camera_from_world_on_orbit({{1, 2, 3}, 4, azimuth, kPi / 2, 0});
    EXPECT_LT((down.inverse().translation() - Vector3d(1, 2, 7)).norm(), 1e-14);
    const Vector3d up_in_world = down.inverse().rotation() * -Vector3d::UnitY();
    EXPECT_LT((up_in_world + Vector3d(std::cos(azimuth), std::sin(azimuth), 0)).norm(), 1e-15);
    const Orbit back = orbit(down, 4);
    EXPECT_NEAR(back.azimuth_rad, azimuth, 1e-15);
    EXPECT_NEAR(back.elevation_rad, kPi / 2, 1e-15);
    EXPECT_NEAR(back.twist_rad, 0, 1e-15);
  }
}

TEST(Orbit, OfACameraThatLooksExactlyDownHasNoTwist) {
  for (const double azimuth : {0.0, 0.5, -2.5}) {
    const Vector3d up(-std::cos(azimuth), -std::sin(azimuth), 0);
    const Orbit found = orbit(camera_from_world_looking_at({1, 2, 7}, {1, 2, 3}, up), 4);
    EXPECT_NEAR(found.azimuth_rad, azimuth, 1e-15);
    EXPECT_NEAR(found.elevation_rad, kPi / 2, 1e-15);
    EXPECT_NEAR(found.twist_rad, 0, 1e-15);
  }
}

TEST(Orbit, ThereAndBackInItsRange) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Orbit there{random_vector(random), random.uniform(0.5, 5), random.uniform(-3.1, 3.1),
                      random.uniform(-1.5, 1.5), random.uniform(-3.1, 3.1)};
    const Orbit back = orbit(camera_from_world_on_orbit(there), there.distance_m);
    EXPECT_LT((back.target - there.target).norm(), 2e-14);
    EXPECT_NEAR(back.azimuth_rad, there.azimuth_rad, 1e-13);
    EXPECT_NEAR(back.elevation_rad, there.elevation_rad, 1e-14);
    EXPECT_NEAR(back.twist_rad, there.twist_rad, 1e-13);
  }
}

TEST(Orbit, AnyPoseIsOnOneWithTheSamePose) {
  Random random(5);
  for (const double from_vertical : {0.0, 1e-15, 1e-13, 1e-10, 1e-7, 1e-3, 1.0, -0.4}) {
    for (int i = 0; i < 100; ++i) {
      const Vector3d v = kPi * Vector3d::NullaryExpr([&] { return random.uniform(-1, 1); });
      const Pose pose = camera_from_world_on_orbit({v, 2, v.x(), kPi / 2 - from_vertical, v.y()});
      expect_same(camera_from_world_on_orbit(orbit(pose, 1.5)), pose, 2e-14);
    }
  }
}

TEST(Orbit, NoDistanceAndNoNumbersAreErrors) {
  EXPECT_THROW(camera_from_world_on_orbit({{0, 0, 0}, 0, 0, 0, 0}), Error);
  EXPECT_THROW(camera_from_world_on_orbit({{0, 0, 0}, 1, kNan, 0, 0}), Error);
  EXPECT_THROW(camera_from_world_on_orbit({{0, kNan, 0}, 1, 0, 0, 0}), Error);
  EXPECT_THROW(orbit(Pose(), -1), Error);
  EXPECT_THROW(orbit(kBadPose, 1), Error);
}

TEST(OpenGLAxes, AreYUpAndLookingAlongMinusZAndItsOwnInverse) {
  EXPECT_EQ(opengl_from_opencv() * Vector3d(1, 2, 3), Vector3d(1, -2, -3));
  EXPECT_EQ((opencv_from_opengl() * opengl_from_opencv()).rotation_matrix(), Matrix3d::Identity());
}

TEST(Viewpoint, ACameraByRollPitchAndYaw) {
  // No angles: it looks along +x, z up. Yaw turns it to the left, a pitch > 0 down.
  const Pose level = camera_from_world_with_angles({}, {1, 2, 3});
  EXPECT_LT((level * Eigen::Vector3d(2, 2, 3) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((level * Eigen::Vector3d(1, 2, 4) - Eigen::Vector3d(0, -1, 0)).norm(), 1e-15);
  const Pose left = camera_from_world_with_angles({0, 0, kPi / 2}, {0, 0, 0});
  EXPECT_LT((left * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
  const Pose down = camera_from_world_with_angles({0, kPi / 2, 0}, {0, 0, 0});
  EXPECT_LT((down * Eigen::Vector3d(0, 0, -1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_TRUE(camera_angles(down).gimbal_lock);
  const RollPitchYaw angles{0.3, -0.7, 2.5};
  const RollPitchYaw back = camera_angles(camera_from_world_with_angles(angles, {1, 2, 3}));
  EXPECT_NEAR(back.roll_rad, angles.roll_rad, 1e-14);
  EXPECT_NEAR(back.pitch_rad, angles.pitch_rad, 1e-14);
  EXPECT_NEAR(back.yaw_rad, angles.yaw_rad, 1e-14);
  EXPECT_FALSE(back.gimbal_lock);
  EXPECT_TRUE(orbit(camera_from_world_on_orbit({{0, 0, 0}, 1, 0.2, kPi / 2}), 1).gimbal_lock);
  EXPECT_FALSE(orbit(camera_from_world_on_orbit({{0, 0, 0}, 1, 0.2, 1}), 1).gimbal_lock);
}

}  // namespace
}  // namespace tagcal
