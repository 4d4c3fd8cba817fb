#pragma once

// Random problems of three and four points, and the errors of their answers.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "poses.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal {

using Eigen::Vector2d;
using Eigen::Vector3d;

using Three = std::array<Vector3d, 3>;
using Four = std::array<Vector3d, 4>;
using FourPixels = std::array<Vector2d, 4>;

inline Vector3d in_cube(Random& random, double half_side) {
  return {random.uniform(-half_side, half_side), random.uniform(-half_side, half_side),
          random.uniform(-half_side, half_side)};
}

inline Pose random_pose(Random& random, const Vector3d& translation) {
  return {Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()),
          translation};
}

// Rotation angle plus the distance at the target's centroid over the camera's distance from it.
template <std::size_t N>
double error_of(const Pose& pose, const Pose& truth, const std::array<Vector3d, N>& points) {
  Vector3d centroid = Vector3d::Zero();
  for (const Vector3d& p : points) centroid += p / static_cast<double>(N);
  return angle_between_rad(pose, truth) +
         (pose * centroid - truth * centroid).norm() / (truth * centroid).norm();
}

// The 50, 99 and 99.9 % quantiles of the errors, for the log.
inline std::string quantiles(std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  std::string text;
  for (const double q : {0.5, 0.99, 0.999, 1.0}) {
    const auto i = static_cast<std::size_t>(q * static_cast<double>(errors.size() - 1));
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), "%.1e ", errors[i]);
    text += number.data();
  }
  return text;
}

// Kinds of random problems: all around the camera (fisheye), usual views, far away, very near.
enum class Views { around, usual, far, near };

inline Vector3d place(Views views, Random& random) {
  if (views == Views::around) return 3 * random_vector(random);
  if (views == Views::near) return 0.5 * random_vector(random);
  const double scale = views == Views::far ? 1000 : random.uniform(3, 8);
  return scale * Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1);
}

// Numbers of bad input: few different values, so that points coincide or are collinear.
inline double bad_number(Random& random) {
  constexpr std::array kNumbers = {0.0,
                                   1.0,
                                   -1.0,
                                   0.5,
                                   0.5,
                                   1e-9,
                                   1e9,
                                   3.0,
                                   0x1p20,
                                   1e-300,
                                   1e300,
                                   -2.0,
                                   0.0,
                                   1.0,
                                   0.1,
                                   std::numeric_limits<double>::quiet_NaN(),
                                   std::numeric_limits<double>::infinity()};
  // The last four seldom, or nothing else would be tried.
  return kNumbers[random.index(random.uniform() < 0.02 ? kNumbers.size() : 9)];
}

inline Vector3d bad_vector(Random& random) {
  return {bad_number(random), bad_number(random), bad_number(random)};
}

}  // namespace tagcal
