#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "poses.hpp"
#include "tagcal/solvers/n_point.hpp"

// Random problems of n points with their truth, and the conditions on every answer.

namespace tagcal {

#ifdef NDEBUG
constexpr int kTrials = 10000;
#else
constexpr int kTrials = 1000;  // the same draws, fewer of them
#endif

constexpr double kPx = 1.0 / 900;

// Points in a box; thickness and distance are in half widths of the box.
struct Setting {
  const char* name;
  int num_points;
  double thickness;
  double distance;
  bool all_around = false;  // seen in any direction, from inside too; else within 50 x 40 degrees
  bool frontal = false;     // else turned at random
};

struct Problem {
  std::vector<Eigen::Vector3d> points, rays;
  Pose truth;
};

inline Pose random_pose(const Setting& s, Random& random) {
  if (s.all_around)
    return {random_rotation(random), s.distance * random_vector(random).normalized()};
  const Eigen::Vector3d along(random.uniform(-0.45, 0.45), random.uniform(-0.35, 0.35), 1);
  if (!s.frontal) return {random_rotation(random), s.distance * along};
  const Eigen::Quaterniond facing(0, 1, 0, 0);  // z out of the board towards the camera
  return {exp_rotation(Eigen::Vector3d(0, 0, random.uniform(-3, 3))) * facing, s.distance * along};
}

inline bool seen(const Setting& s, const Problem& p) {
  return std::all_of(p.points.begin(), p.points.end(), [&](const Eigen::Vector3d& x) {
    const Eigen::Vector3d y = p.truth * x;
    return y.norm() > 0.1 && (s.all_around || y.z() > 0.2);
  });
}

inline Problem make_problem(const Setting& s, double sigma, Random& random) {
  Problem p;
  do {
    p = {};
    for (int i = 0; i < s.num_points; ++i)
      p.points.push_back(
          {random.uniform(-1, 1), random.uniform(-1, 1), s.thickness * random.uniform(-1, 1)});
    p.truth = random_pose(s, random);
  } while (!seen(s, p));
  for (const Eigen::Vector3d& x : p.points)
    p.rays.push_back(random.uniform(0.5, 2) *
                     ((p.truth * x).normalized() + sigma * random_vector(random)));
  const Pose target_from_box(random_rotation(random), random_vector(random));
  for (Eigen::Vector3d& x : p.points) x = target_from_box * x;
  p.truth = p.truth * target_from_box.inverse();
  return p;
}

// The index of the truth among the poses; -1 if it is missing.
inline int place_of_truth(const Solutions<Pose, 4>& poses, const Problem& p, double tolerance) {
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (angle_between_rad(poses[i], p.truth) < tolerance &&
        distance_between_m(poses[i], p.truth) < tolerance * (1 + p.truth.translation().norm()))
      return static_cast<int>(i);
  return -1;
}

inline void expect_proper(const Solutions<Pose, 4>& poses, const Problem& p) {
  for (const Pose& pose : poses) {
    ASSERT_TRUE(pose.matrix().allFinite());
    ASSERT_NEAR(pose.rotation_matrix().determinant(), 1, 1e-12);
    for (std::size_t i = 0; i < p.points.size(); ++i)
      ASSERT_GT(p.rays[i].dot(pose * p.points[i]), 0);
  }
}

// The largest angle between a ray and the point that it should show.
inline double largest_angle(const Pose& pose, const Problem& p) {
  double largest = 0;
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    const Eigen::Vector3d x = pose * p.points[i];
    largest = std::max(largest, std::atan2(p.rays[i].cross(x).norm(), p.rays[i].dot(x)));
  }
  return largest;
}

}  // namespace tagcal
