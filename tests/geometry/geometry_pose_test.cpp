#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "poses.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d vector_of_length(Random& random, double length) {
  const Vector3d v(random.normal(), random.normal(), random.normal());
  return length * v.normalized();
}

const double kAngles[] = {0,   1e-300, 1e-160, 1e-12, 1e-8, 1e-5,       9.99e-4,    1e-3,
                          0.1, 0.5,    1.0,    2.0,   3.0,  kPi - 1e-5, kPi - 1e-9, kPi};

TEST(Rotation, LogarithmInvertsExponentialFromZeroToPi) {
  Random random(1);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Vector3d v = vector_of_length(random, angle);
      const Vector3d back = log_rotation(exp_rotation(v));
      // At pi both signs are right.
      const double error = std::min((back - v).norm(), angle > 3.14159 ? (back + v).norm() : 1e9);
      EXPECT_LE(error, 1e-15 + 4e-15 * angle) << "angle " << angle;
    }
  }
}

TEST(Rotation, ExponentialAgreesWithOpenCV) {
  Random random(2);
  for (const double angle : {1e-4, 0.01, 0.5, 1.5, 3.0, 3.14}) {
    const Vector3d v = vector_of_length(random, angle);
    cv::Matx33d theirs;
    cv::Rodrigues(cv::Vec3d(v.x(), v.y(), v.z()), theirs);
    const Matrix3d ours = exp_rotation(v).toRotationMatrix();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours(r, c), theirs(r, c), 1e-14);
  }
}

TEST(Rotation, NegatedQuaternionIsTheSameRotation) {
  const Quaterniond q = exp_rotation({0.3, -0.2, 0.7});
  EXPECT_LT((log_rotation(Quaterniond(-q.coeffs())) - log_rotation(q)).norm(), 1e-15);
}

TEST(Pose, ComposesByMatchingNeighbours) {
  const Pose a_from_b(exp_rotation({0.1, 0.2, 0.3}), {1, 2, 3});
  const Pose b_from_c(exp_rotation({-1.0, 0.5, 0.2}), {-4, 0, 2});
  const Vector3d x_in_c(0.3, 0.6, -0.9);
  EXPECT_LT((a_from_b * b_from_c * x_in_c - a_from_b * (b_from_c * x_in_c)).norm(), 1e-14);
  EXPECT_LT(((a_from_b * b_from_c).matrix() - a_from_b.matrix() * b_from_c.matrix()).norm(), 1e-14);
  EXPECT_LT((a_from_b.inverse() * (a_from_b * x_in_c) - x_in_c).norm(), 1e-14);
}

TEST(Pose, LogarithmInvertsExponential) {
  Random random(3);
  for (const double angle : kAngles) {
    if (angle > 3.1415) continue;  // the sign of the axis is free at pi
    Vector6d twist;
    twist << vector_of_length(random, angle), vector_of_length(random, 2.0);
    EXPECT_LT((log_pose(exp_pose(twist)) - twist).norm(), 1e-11) << "angle " << angle;
  }
}

TEST(Pose, ExponentialOfAScrew) {
  // A quarter turn about z while moving along a circle of radius 1 and up by 0.5.
  Vector6d twist;
  twist << 0, 0, kPi / 2, kPi / 2, 0, 0.5;
  EXPECT_LT((exp_pose(twist).translation() - Vector3d(1, 1, 0.5)).norm(), 1e-14);
}

TEST(Pose, ExponentialIsTheLimitOfSmallSteps) {
  Vector6d twist;
  twist << 0.4, -1.1, 0.6, 0.3, 0.2, -0.7;
  Pose steps;
  const Pose step = exp_pose(twist / 1024);
  for (int i = 0; i < 1024; ++i) steps = step * steps;
  EXPECT_LT(angle_between_rad(steps, exp_pose(twist)), 1e-12);
  EXPECT_LT(distance_between_m(steps, exp_pose(twist)), 1e-12);
}

TEST(Rotation, LeftJacobianAgreesWithDifferences) {
  Random random(4);
  for (const double angle : {0.0, 1e-9, 1e-4, 0.05, 0.11, 1.0, 3.1}) {
    const Vector3d v = vector_of_length(random, angle);
    const Matrix3d j = left_jacobian(v);
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-6;
      const Vector3d difference = log_rotation(exp_rotation(v + h * Vector3d::Unit(k)) *
                                               exp_rotation(v - h * Vector3d::Unit(k)).conjugate());
      EXPECT_LT((difference / (2 * h) - j.col(k)).norm(), 1e-9) << angle;
    }
  }
}

TEST(Pose, RetractAndMinusAreInverse) {
  const Pose a(exp_rotation({0.1, 2.0, 0.3}), {1, 2, 3});
  const Pose b(exp_rotation({-1.0, 0.5, 0.2}), {-4, 0, 2});
  const Pose back = retract(a, minus(b, a));
  EXPECT_LT(angle_between_rad(back, b), 1e-14);
  EXPECT_LT(distance_between_m(back, b), 1e-14);
}

TEST(Pose, AngleAndDistanceBetween) {
  const Pose a(exp_rotation({0, 0, 0.25}), {1, 0, 0});
  const Pose b(exp_rotation({0, 0, -0.5}), {1, 3, 4});
  EXPECT_NEAR(angle_between_rad(a, b), 0.75, 1e-15);
  EXPECT_NEAR(distance_between_m(a, b), 5, 1e-15);
}

TEST(NearestRotation, LeavesARotationAndMendsAMirroredOne) {
  const Matrix3d rotation = exp_rotation({0.3, -0.8, 1.2}).toRotationMatrix();
  EXPECT_LT((nearest_rotation(rotation).toRotationMatrix() - rotation).norm(), 1e-14);
  EXPECT_LT((nearest_rotation(2.5 * rotation).toRotationMatrix() - rotation).norm(), 1e-14);
  EXPECT_NEAR(nearest_rotation(-rotation).toRotationMatrix().determinant(), 1, 1e-14);
}

// No other rotation is nearer, by the sum of squared differences; mirrored matrices too.
TEST(NearestRotation, IsNearerThanAllOthers) {
  Random random(11);
  for (int i = 0; i < 200; ++i) {
    Eigen::Matrix3d matrix;
    for (double& entry : matrix.reshaped()) entry = random.normal();
    const Eigen::Quaterniond nearest = nearest_rotation(matrix);
    const double least = (nearest.toRotationMatrix() - matrix).norm();
    for (int k = 0; k < 100; ++k) {
      const double size = k % 2 == 0 ? 0.01 : 1;
      const Eigen::Vector3d turn(random.normal(), random.normal(), random.normal());
      const Eigen::Quaterniond other = exp_rotation(size * turn) * nearest;
      EXPECT_LE(least, (other.toRotationMatrix() - matrix).norm() + 1e-12) << i;
    }
  }
}

}  // namespace
}  // namespace tagcal
