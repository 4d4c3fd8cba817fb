#include "tagcal/geometry/viewpoint.hpp"

#include <gtest/gtest.h>

#include "poses.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// How far from straight up an elevation or a pitch is; negative: over the top.
constexpr double kFromVertical[] = {0, 1e-15, 1e-13, 1e-10, 1e-7, 1e-3, 0.1, 1, kPi / 2, -0.4};

double climb(double from_vertical, int i) {
  return i % 2 == 0 ? kPi / 2 - from_vertical : from_vertical - kPi / 2;
}

TEST(RollPitchYaw, IsTheProductOfTheThreeTurns) {
  const Quaterniond q = rotation_from_roll_pitch_yaw({0.1, 0.2, 0.3});
  const Pose turns = rotation_about_z(0.3) * rotation_about_y(0.2) * rotation_about_x(0.1);
  EXPECT_LT((q.toRotationMatrix() - turns.rotation_matrix()).norm(), 1e-15);
  // Nose (x) down by a positive pitch, then heading y.
  const Matrix3d m = rotation_from_roll_pitch_yaw({0, kPi / 6, kPi / 2}).toRotationMatrix();
  EXPECT_LT((m.col(0) - Vector3d(0, std::sqrt(3.0) / 2, -0.5)).norm(), 1e-15);
}

TEST(RollPitchYaw, ThereAndBackAwayFromGimbalLock) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const RollPitchYaw there{random.uniform(-3.1, 3.1), random.uniform(-1.5, 1.5),
                             random.uniform(-3.1, 3.1)};
    const RollPitchYaw back = roll_pitch_yaw(rotation_from_roll_pitch_yaw(there));
    EXPECT_FALSE(back.gimbal_lock);
    EXPECT_NEAR(back.roll_rad, there.roll_rad, 2e-14);
    EXPECT_NEAR(back.pitch_rad, there.pitch_rad, 1e-14);
    EXPECT_NEAR(back.yaw_rad, there.yaw_rad, 2e-14);
  }
}

TEST(RollPitchYaw, GimbalLockIsNamedAndItsAnglesReproduceTheRotation) {
  Random random(7);
  for (const double from_vertical : kFromVertical) {
    for (int i = 0; i < 100; ++i) {
      const Quaterniond q = rotation_from_roll_pitch_yaw(
          {random.uniform(-kPi, kPi), climb(from_vertical, i), random.uniform(-kPi, kPi)});
      const RollPitchYaw angles = roll_pitch_yaw(q);
      EXPECT_EQ(angles.gimbal_lock, std::abs(from_vertical) < 1e-6) << from_vertical;
      const Matrix3d again = rotation_from_roll_pitch_yaw(angles).toRotationMatrix();
      EXPECT_LT((again - q.toRotationMatrix()).cwiseAbs().maxCoeff(), 2e-14) << from_vertical;
    }
  }
}

TEST(RollPitchYaw, StraightDownHasYawMinusRollAndStraightUpTheirSum) {
  const RollPitchYaw down = roll_pitch_yaw(rotation_from_roll_pitch_yaw({0.3, kPi / 2, 1.0}));
  EXPECT_NEAR(down.yaw_rad, 0.7, 1e-15);
  EXPECT_NEAR(down.roll_rad, 0, 1e-15);
  const RollPitchYaw up = roll_pitch_yaw(rotation_from_roll_pitch_yaw({0.3, -kPi / 2, 1.0}));
  EXPECT_NEAR(up.yaw_rad, 1.3, 1e-15);
  EXPECT_NEAR(up.roll_rad, 0, 1e-15);
}

TEST(RollPitchYaw, AnAxisThatIsVerticalToRoundingHasNoRoll) {
  for (const double yaw : {0.7, -3.0}) {
    const Quaterniond down = exp_rotation({0, 0, yaw}) * Quaterniond(1, 0, 1, 0).normalized();
    const RollPitchYaw angles = roll_pitch_yaw(down);
    EXPECT_TRUE(angles.gimbal_lock);
    EXPECT_NEAR(angles.yaw_rad, yaw, 1e-15);
    EXPECT_NEAR(angles.roll_rad, 0, 1e-15);
  }
}

// world_from_aircraft = Rz(phi) Ry(theta) T(0,0,rho) Ry(-theta) Rz(-phi) Rz(yaw) Rx(pitch) Ry(roll)
TEST(Aircraft, IsPlacedByTheWholeProduct) {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    const Aircraft plane{{random.uniform(0, 9), random.uniform(0, kPi), random.uniform(-kPi, kPi)},
                         random.uniform(-kPi, kPi),
                         random.uniform(-kPi, kPi),
                         random.uniform(-kPi, kPi)};
    const auto& [rho, theta, phi] = plane.position;
    const Pose product = rotation_about_z(phi) * rotation_about_y(theta) *
                         translation({0, 0, rho}) * rotation_about_y(-theta) *
                         rotation_about_z(-phi) * rotation_about_z(plane.yaw_rad) *
                         rotation_about_x(plane.pitch_rad) * rotation_about_y(plane.roll_rad);
    expect_same(world_from_aircraft(plane), product, 2e-14);
  }
}

TEST(Aircraft, TurnsLeftPitchesUpAndRollsItsRightWingDown) {
  const Spherical above{5, 0, 0};
  const auto axis = [&](const Aircraft& plane, int k) {
    return Vector3d(world_from_aircraft(plane).rotation() * Vector3d::Unit(k));
  };
  EXPECT_LT((world_from_aircraft({above}).translation() - Vector3d(0, 0, 5)).norm(), 1e-15);
  EXPECT_LT((axis({above, kPi / 2, 0, 0}, 1) - Vector3d(-1, 0, 0)).norm(), 1e-15);
  EXPECT_LT((axis({above, 0, kPi / 2, 0}, 1) - Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((axis({above, 0, 0, kPi / 2}, 0) - Vector3d(0, 0, -1)).norm(), 1e-15);
}

TEST(Aircraft, ThereAndBack) {
  Random random(9);
  for (int i = 0; i < 1000; ++i) {
    const Aircraft there{
        {random.uniform(0.5, 9), random.uniform(0.1, 3), random.uniform(-3.1, 3.1)},
        random.uniform(-3.1, 3.1),
        random.uniform(-1.5, 1.5),
        random.uniform(-3.1, 3.1)};
    const Aircraft back = aircraft(world_from_aircraft(there));
    EXPECT_NEAR(back.position.rho, there.position.rho, 1e-14);
    EXPECT_NEAR(back.position.theta_rad, there.position.theta_rad, 1e-14);
    EXPECT_NEAR(back.position.phi_rad, there.position.phi_rad, 1e-14);
    EXPECT_NEAR(back.yaw_rad, there.yaw_rad, 2e-14);
    EXPECT_NEAR(back.pitch_rad, there.pitch_rad, 1e-14);
    EXPECT_NEAR(back.roll_rad, there.roll_rad, 2e-14);
    EXPECT_FALSE(back.gimbal_lock);
  }
}

TEST(Aircraft, FlyingStraightUpIsGimbalLockAndStillReproduced) {
  Random random(10);
  for (const double from_vertical : kFromVertical) {
    for (int i = 0; i < 100; ++i) {
      const Pose pose = world_from_aircraft({{2, 1, 1},
                                             random.uniform(-kPi, kPi),
                                             climb(from_vertical, i),
                                             random.uniform(-kPi, kPi)});
      const Aircraft found = aircraft(pose);
      EXPECT_EQ(found.gimbal_lock, std::abs(from_vertical) < 1e-6) << from_vertical;
      expect_same(world_from_aircraft(found), pose, 2e-14);
    }
  }
}

TEST(Aircraft, ThePilotSeesWhatIsAheadAndUpInTheImage) {
  Random random(11);
  for (int i = 0; i < 100; ++i) {
    const Aircraft plane{{3, 1, 2}, random.normal(), random.normal(), random.normal()};
    const Pose camera_from_plane =
        camera_from_world_in_aircraft(plane) * world_from_aircraft(plane);
    EXPECT_LT((camera_from_plane * Vector3d(0, 1, 0) - Vector3d(0, 0, 1)).norm(), 1e-14);
    EXPECT_LT((camera_from_plane * Vector3d(1, 0, 0) - Vector3d(1, 0, 0)).norm(), 1e-14);
    EXPECT_LT((camera_from_plane * Vector3d(0, 0, 1) - Vector3d(0, -1, 0)).norm(), 1e-14);
  }
}

TEST(Attitude, NumbersThatAreNoneAreErrors) {
  EXPECT_THROW(rotation_from_roll_pitch_yaw({kNan, 0, 0}), Error);
  EXPECT_THROW(roll_pitch_yaw(Quaterniond(kNan, 0, 0, 1)), Error);
  EXPECT_THROW(world_from_aircraft({{kNan, 0, 0}}), Error);
  EXPECT_THROW(world_from_aircraft({{1, 0, 0}, 0, kNan, 0}), Error);
  EXPECT_THROW(aircraft(kBadPose), Error);
}

}  // namespace
}  // namespace tagcal
