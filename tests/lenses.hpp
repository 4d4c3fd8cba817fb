#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/camera/lens.hpp"
#include "tagcal/random.hpp"

// Lenses and points drawn at random.

namespace tagcal {

// Realistic lenses, with mild and strong distortion, drawn at random.
template <typename L>
L random_lens(Random& random);

template <>
inline Perspective random_lens(Random& random) {
  const double f = random.uniform(300, 3000);
  const double k = random.uniform(0, 1) < 0.5 ? 0 : 1;  // half of them rational
  return Perspective(
      {f, f * random.uniform(0.9, 1.1), random.uniform(200, 800), random.uniform(200, 800),
       random.uniform(-0.4, 0.3), random.uniform(-0.1, 0.2), random.uniform(-2e-3, 2e-3),
       random.uniform(-2e-3, 2e-3), random.uniform(-0.05, 0.05), k * random.uniform(-0.3, 0.3),
       k * random.uniform(-0.1, 0.1), k * random.uniform(-0.05, 0.05)});
}

template <>
inline Fisheye random_lens(Random& random) {
  const double f = random.uniform(200, 1000);
  return Fisheye({f, f * random.uniform(0.9, 1.1), random.uniform(200, 800),
                  random.uniform(200, 800), random.uniform(-0.05, 0.05),
                  random.uniform(-0.02, 0.02), random.uniform(-0.01, 0.01),
                  random.uniform(-0.002, 0.002)});
}

template <>
inline Parallel random_lens(Random& random) {
  return Parallel({random.uniform(10, 5000), random.uniform(10, 5000), random.uniform(200, 800),
                   random.uniform(200, 800), random.uniform(-1, 1), random.uniform(-1, 1)});
}

template <>
inline DoubleSphere random_lens(Random& random) {
  const double f = random.uniform(200, 1000);
  return DoubleSphere({f, f * random.uniform(0.9, 1.1), random.uniform(200, 800),
                       random.uniform(200, 800), random.uniform(-0.6, 0.5), random.uniform(0, 1)});
}

template <>
inline ExtendedUnified random_lens(Random& random) {
  const double f = random.uniform(200, 1000);
  return ExtendedUnified({f, f * random.uniform(0.9, 1.1), random.uniform(200, 800),
                          random.uniform(200, 800), random.uniform(0, 1), random.uniform(0.5, 2)});
}

// A point at an angle from the axis that is inside the domain of the lens, the border included.
inline Eigen::Vector3d point_inside(const Perspective& lens, Random& random) {
  const double radius = std::min(lens.max_radius() * (1 - 1e-6), 2.5) * random.uniform();
  const double turn = random.uniform(0, 2 * std::numbers::pi);
  return random.uniform(0.1, 20) *
         Eigen::Vector3d(radius * std::cos(turn), radius * std::sin(turn), 1);
}

template <typename L>
Eigen::Vector3d point_inside(const L& lens, Random& random) {
  const double theta = lens.max_angle() * (1 - 1e-6) * random.uniform();
  const double turn = random.uniform(0, 2 * std::numbers::pi);
  return random.uniform(0.1, 20) * Eigen::Vector3d(std::sin(theta) * std::cos(turn),
                                                   std::sin(theta) * std::sin(turn),
                                                   std::cos(theta));
}

inline Eigen::Vector3d point_inside(const Parallel&, Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

}  // namespace tagcal
