#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "n_point_fixture.hpp"
#include "tagcal/error.hpp"
#include "tagcal/solvers/plane.hpp"
#include "tagcal/solvers/weak_perspective.hpp"

namespace tagcal {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(NPointBadInput, NoneWithoutEnoughPoints) {
  Random random(8);
  const Problem p = make_problem({"space", 8, 1, 3}, 0, random);
  for (std::size_t n = 0; n < 3; ++n)
    EXPECT_TRUE(pnp(std::span(p.points).first(n), std::span(p.rays).first(n)).empty());
}

// Spoils a problem in one of several ways; true if no pose can be right.
bool spoil(Problem& p, std::size_t kind, Random& random) {
  const std::size_t n = p.points.size(), i = random.index(n);
  const double infinity = std::numeric_limits<double>::infinity();
  switch (kind) {
    case 0:
      p.points[i].y() = std::nan("");
      return true;
    case 1:
      p.rays[i].z() = std::nan("");
      return true;
    case 2:
      p.points[i].x() = infinity;
      return true;
    case 3:
      p.rays[i].x() = -infinity;
      return true;
    case 4:
      p.rays[i].setZero();
      return true;
    case 5:
      std::fill(p.points.begin(), p.points.end(), p.points[0]);
      return true;
    case 6:
      std::fill(p.rays.begin(), p.rays.end(), p.rays[0]);
      return true;
    case 7: {  // on a line, seen where it is
      const Vector3d a = p.points[0], d = random_vector(random);
      for (std::size_t k = 0; k < n; ++k) {
        p.points[k] = a + random.uniform(-1, 1) * d;
        p.rays[k] = p.truth * p.points[k];
      }
      return true;
    }
    default:
      return false;
  }
}

// Unusual inputs that determine a pose.
void make_odd(Problem& p, std::size_t kind, Random& random) {
  const std::size_t n = p.points.size();
  const double unit = std::pow(10, random.uniform(-9, 9));
  if (kind == 0) {  // duplicates
    p.points[n - 1] = p.points[0];
    p.rays[n - 1] = p.rays[0];
  } else if (kind == 1) {  // huge and tiny rays
    for (Vector3d& v : p.rays) v *= std::pow(10, random.uniform(-250, 250));
  } else if (kind == 2) {  // units
    for (Vector3d& x : p.points) x *= unit;
    p.truth = Pose(p.truth.rotation(), unit * p.truth.translation());
  } else {  // half a turn
    const Pose half(Quaterniond(0, 0, 1, 0), Vector3d::Zero());
    for (Vector3d& x : p.points) x = half * x;
    p.truth = p.truth * half;
  }
}

TEST(NPointBadInput, AnotherNumberOfRaysIsAnError) {
  const std::vector<Eigen::Vector3d> points(6, Eigen::Vector3d::Ones());
  const std::vector<Eigen::Vector2d> pixels(5, Eigen::Vector2d::Ones());
  EXPECT_THROW(pnp(points, std::span<const Vector3d>(points).first(5)), Error);
  EXPECT_THROW(homography(pixels, points), Error);
  EXPECT_THROW(weak_perspective_poses(points, pixels), Error);
}

TEST(NPointBadInput, BadInputGivesNone) {
  Random random(9);
  for (int i = 0; i < kTrials; ++i) {
    const int n = 3 + static_cast<int>(random.index(10));
    Problem p = make_problem({"any", n, i % 2 ? 1.0 : 0.0, 3}, 0, random);
    ASSERT_TRUE(spoil(p, static_cast<std::size_t>(i) % 8, random));
    EXPECT_TRUE(pnp(p.points, p.rays).empty()) << i % 8 << ", " << n << " points";
  }
}

TEST(NPointBadInput, OddInputGivesTheRightPose) {
  Random random(10);
  for (int i = 0; i < kTrials; ++i) {
    const int n = 7 + static_cast<int>(random.index(10));
    Problem p = make_problem({"any", n, i % 3 ? 1.0 : 0.0, 3}, 0, random);
    make_odd(p, static_cast<std::size_t>(i) % 4, random);
    const auto poses = pnp(p.points, p.rays);
    ASSERT_FALSE(poses.empty()) << i;
    EXPECT_LT(angle_between_rad(poses.front(), p.truth), 1e-6) << i;
  }
}

TEST(NPointBadInput, RandomRaysNeverGiveAnImproperPose) {
  Random random(11);
  for (int i = 0; i < kTrials / 2; ++i) {
    const int n = 3 + static_cast<int>(random.index(6));
    Problem p = make_problem({"any", n, i % 2 ? 1.0 : 0.0, 3}, 0, random);
    for (Vector3d& v : p.rays) v = random_vector(random);
    ASSERT_NO_FATAL_FAILURE(expect_proper(pnp(p.points, p.rays), p)) << i;
  }
}

}  // namespace
}  // namespace tagcal
