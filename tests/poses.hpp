#pragma once

// Numbers, random vectors, rotations and poses.

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"

namespace tagcal {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline const Pose kBadPose(Eigen::Quaterniond(1, 0, 0, 0), Eigen::Vector3d(0, kNan, 0));

inline Eigen::Vector3d random_vector(Random& random) {
  return Eigen::Vector3d::NullaryExpr([&] { return random.normal(); });
}

inline Eigen::Quaterniond random_rotation(Random& random) {
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized();
}

inline Pose random_pose(Random& random) {
  const Eigen::Quaterniond turn = exp_rotation(2 * random_vector(random));
  return {turn, random_vector(random)};
}

inline void expect_same(const Pose& a, const Pose& b, double tolerance = 4e-15) {
  EXPECT_LE((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance) << a.matrix();
}

}  // namespace tagcal
