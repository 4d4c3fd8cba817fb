#include "tagcal/solvers/weak_perspective.hpp"
#include "poses.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tagcal {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

#ifdef NDEBUG
constexpr int kWeakTrials = 10000;
#else
constexpr int kWeakTrials = 1000;  // the same draws, fewer of them
#endif

struct Problem {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  WeakPerspectivePose truth;
};

void observe(Problem& p, double sigma_px, Random& random) {
  p.pixels.clear();
  for (const Vector3d& x : p.points)
    p.pixels.push_back(p.truth.scale_px_per_m * (p.truth.camera_from_target * x).head<2>() +
                       sigma_px * Vector2d(random.normal(), random.normal()));
}

// Points in a box of 2 x 2 x 2 thickness metres, turned and moved, seen some hundred pixels wide.
Problem make_problem(int num_points, double thickness, double sigma_px, Random& random) {
  Problem p;
  const Pose target_from_box(random_rotation(random),
                             {random.normal(), random.normal(), random.normal()});
  for (int i = 0; i < num_points; ++i)
    p.points.push_back(target_from_box * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1),
                                                  thickness * random.uniform(-1, 1)));
  p.truth.scale_px_per_m = random.uniform(20, 300);
  p.truth.camera_from_target = Pose(random_rotation(random), {random.normal(), random.normal(), 0});
  observe(p, sigma_px, random);
  return p;
}

int place_of_truth(const Solutions<WeakPerspectivePose, 2>& poses, const Problem& p,
                   double tolerance) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const WeakPerspectivePose& pose = poses[i];
    const double scale_error = pose.scale_px_per_m / p.truth.scale_px_per_m - 1;
    const bool same_place =
        (pose.camera_from_target * p.points[0] - p.truth.camera_from_target * p.points[0])
            .head<2>()
            .norm() < tolerance;
    if (std::abs(scale_error) < tolerance && same_place &&
        angle_between_rad(pose.camera_from_target, p.truth.camera_from_target) < tolerance)
      return static_cast<int>(i);
  }
  return -1;
}

double rms_of(const WeakPerspectivePose& pose, const Problem& p) {
  double square = 0;
  for (std::size_t i = 0; i < p.points.size(); ++i)
    square +=
        (pose.scale_px_per_m * (pose.camera_from_target * p.points[i]).head<2>() - p.pixels[i])
            .squaredNorm();
  return std::sqrt(square / static_cast<double>(p.points.size()));
}

void expect_proper(const Solutions<WeakPerspectivePose, 2>& poses, const Problem& p) {
  double last = 0;
  for (const WeakPerspectivePose& pose : poses) {
    ASSERT_TRUE(pose.camera_from_target.matrix().allFinite());
    ASSERT_GT(pose.scale_px_per_m, 0);
    ASSERT_EQ(pose.camera_from_target.translation().z(), 0);
    ASSERT_NEAR(pose.rms_px, rms_of(pose, p), 1e-6);
    ASSERT_LE(last, pose.rms_px);
    last = pose.rms_px;
  }
}

TEST(WeakPerspective, FindsTheTruthInSpaceWithoutNoise) {
  for (const int n : {4, 5, 8, 30}) {
    Random random(1);
    for (int i = 0; i < kWeakTrials; ++i) {
      // Four points may lie almost in a plane.
      const Problem p = make_problem(n, 1, 0, random);
      const auto poses = weak_perspective_poses(p.points, p.pixels);
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
      EXPECT_GE(place_of_truth(poses, p, 1e-6), 0) << n << " points, " << i;
      if (n >= 8) {
        EXPECT_EQ(poses.size(), 1u) << i;
      }
    }
  }
}

TEST(WeakPerspective, FindsTheTruthOfAPlaneAndItsOtherTilt) {
  for (const int n : {4, 8, 30}) {
    Random random(2);
    for (int i = 0; i < kWeakTrials; ++i) {
      const Problem p = make_problem(n, 0, 0, random);
      const auto poses = weak_perspective_poses(p.points, p.pixels);
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
      EXPECT_GE(place_of_truth(poses, p, 1e-5), 0) << n << " points, " << i;
      for (const WeakPerspectivePose& pose : poses) EXPECT_LT(pose.rms_px, 1e-6);
      EXPECT_EQ(poses.size(), 2u) << i;
    }
  }
}

TEST(WeakPerspective, NearlyAPlaneIsRightToo) {
  for (const double thickness : {1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1}) {
    Random random(3);
    for (int i = 0; i < kWeakTrials / 5; ++i) {
      const Problem p = make_problem(8, thickness, 0, random);
      const auto poses = weak_perspective_poses(p.points, p.pixels);
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
      EXPECT_GE(place_of_truth(poses, p, 1e-5), 0) << thickness << ", " << i;
      if (thickness >= 1e-2) {
        EXPECT_EQ(place_of_truth(poses, p, 1e-5), 0) << thickness << ", " << i;
      }
    }
  }
}

TEST(WeakPerspective, AFrontalPlaneHasOnePose) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    Problem p = make_problem(4, 0, 0, random);
    for (std::size_t k = 0; k < 4; ++k)
      p.points[k] = Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, 0) + Vector3d(3, 4, 5);
    const Quaterniond facing(0, 1, 0, 0);
    p.truth.camera_from_target =
        Pose(exp_rotation({0, 0, random.uniform(-3, 3)}) * facing, {random.normal(), 1, 0});
    observe(p, 0, random);
    const auto poses = weak_perspective_poses(p.points, p.pixels);
    ASSERT_EQ(poses.size(), 1u) << i;
    EXPECT_EQ(place_of_truth(poses, p, 1e-6), 0) << i;
  }
}

// Reference without code of the library: the error of the best scale and translation for a
// rotation, and Levenberg's descent on it by finite differences.
struct Peer {
  const Problem& p;

  VectorXd residuals(const Quaterniond& rotation) const {
    const auto n = static_cast<Eigen::Index>(p.points.size());
    Eigen::Matrix2Xd x(2, n), u(2, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      x.col(i) = (rotation * p.points[k]).head<2>();
      u.col(i) = p.pixels[k];
    }
    const Vector2d x_mean = x.rowwise().mean(), u_mean = u.rowwise().mean();
    x.colwise() -= x_mean;
    u.colwise() -= u_mean;
    const Eigen::Matrix2Xd r = x.cwiseProduct(u).sum() / x.squaredNorm() * x - u;
    return r.reshaped();
  }

  double descend(Quaterniond q) const {
    double damping = 1;
    VectorXd r = residuals(q);
    for (int i = 0; i < 60; ++i) {
      Eigen::MatrixX3d jacobian(r.size(), 3);
      for (int a = 0; a < 3; ++a) {
        const Vector3d d = 1e-6 * Vector3d::Unit(a);
        jacobian.col(a) = (residuals(exp_rotation(d) * q) - residuals(exp_rotation(-d) * q)) / 2e-6;
      }
      Eigen::Matrix3d normal = jacobian.transpose() * jacobian;
      normal.diagonal().array() += damping;
      const Vector3d step = -normal.ldlt().solve(jacobian.transpose() * r);
      const VectorXd next = residuals(exp_rotation(step) * q);
      const bool better = next.squaredNorm() < r.squaredNorm();
      damping *= better ? 0.2 : 5;
      if (!better) continue;
      q = exp_rotation(step) * q;
      r = next;
    }
    return std::sqrt(2 * r.squaredNorm() / static_cast<double>(r.size()));
  }
};

TEST(WeakPerspective, TheFirstIsTheGlobalMinimumUnderNoise) {
  for (const double thickness : {0.0, 1e-3, 0.02, 0.1, 0.3, 1.0}) {
    Random random(5);
    for (int i = 0; i < 30; ++i) {
      const Problem p = make_problem(i % 2 ? 6 : 12, thickness, 0.5, random);
      const auto poses = weak_perspective_poses(p.points, p.pixels);
      ASSERT_FALSE(poses.empty());
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
      double best = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 10; ++k) best = std::min(best, Peer{p}.descend(random_rotation(random)));
      EXPECT_LT(poses.front().rms_px, best * (1 + 1e-9)) << thickness << " " << i;
      EXPECT_GT(poses.front().rms_px, best * (1 - 1e-5)) << thickness << " " << i;
      // Each pose is a minimum: the reference descent stays there.
      for (const WeakPerspectivePose& pose : poses)
        EXPECT_NEAR(Peer{p}.descend(pose.camera_from_target.rotation()), pose.rms_px, 1e-9);
    }
  }
}

TEST(WeakPerspective, UnitAndOriginDoNotMatter) {
  Random random(6);
  for (const double thickness : {0.0, 1.0}) {
    for (int i = 0; i < 200; ++i) {
      Problem p = make_problem(8, thickness, 0.5, random);
      for (Vector3d& x : p.points) x = (x * 0x1p20).array().round() * 0x1p-20;
      const auto poses = weak_perspective_poses(p.points, p.pixels);
      ASSERT_FALSE(poses.empty());
      const auto compare = [&](double unit, const Vector3d& offset) {
        std::vector<Vector3d> moved;
        for (const Vector3d& x : p.points) moved.push_back(unit * (x + offset));
        const auto again = weak_perspective_poses(moved, p.pixels);
        ASSERT_EQ(again.size(), poses.size()) << thickness << " " << i << " " << unit;
        EXPECT_NEAR(again.front().rms_px, poses.front().rms_px, 1e-8);
        EXPECT_NEAR(again.front().scale_px_per_m * unit / poses.front().scale_px_per_m, 1, 1e-9);
        EXPECT_LT(
            angle_between_rad(again.front().camera_from_target, poses.front().camera_from_target),
            1e-8);
      };
      for (const double unit : {1e-9, 1e-3, 1e9}) compare(unit, Vector3d::Zero());
      if (thickness > 0) compare(1, Vector3d(0x1p20, -0x1p20, 0x1p19));
    }
  }
}

TEST(WeakPerspective, BadInputGivesNone) {
  Random random(7);
  const double infinity = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kWeakTrials; ++i) {
    const int n = 4 + static_cast<int>(random.index(10));
    Problem p = make_problem(n, i % 2 ? 1 : 0, 0, random);
    const std::size_t k = random.index(p.points.size());
    const Vector3d a = p.points[0], d = p.points[1] - a;
    switch (i % 7) {
      case 0:
        p.points[k].y() = std::nan("");
        break;
      case 1:
        p.pixels[k].x() = std::nan("");
        break;
      case 2:
        p.points[k].x() = -infinity;
        break;
      case 3:
        p.pixels[k].y() = infinity;
        break;
      case 4:
        std::fill(p.points.begin(), p.points.end(), a);
        break;
      case 5:
        std::fill(p.pixels.begin(), p.pixels.end(), p.pixels[0]);
        break;
      case 6:
        for (Vector3d& x : p.points) x = a + random.uniform(-1, 1) * d;
        observe(p, 0, random);
        break;
    }
    EXPECT_TRUE(weak_perspective_poses(p.points, p.pixels).empty()) << i % 7;
  }
  const Problem p = make_problem(3, 1, 0, random);
  EXPECT_TRUE(weak_perspective_poses(p.points, p.pixels).empty());
}

TEST(WeakPerspective, RandomPixelsNeverGiveAnImproperPose) {
  Random random(8);
  for (int i = 0; i < kWeakTrials; ++i) {
    const int n = 4 + static_cast<int>(random.index(6));
    Problem p = make_problem(n, std::pow(10, random.uniform(-8, 0)), 0, random);
    for (Vector2d& u : p.pixels) u = 300 * Vector2d(random.normal(), random.normal());
    if (i % 5 == 0) p.points[1] = p.points[0];
    if (i % 7 == 0) p.pixels[1] = p.pixels[0];
    const auto poses = weak_perspective_poses(p.points, p.pixels);
    EXPECT_FALSE(poses.empty()) << i;
    ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
  }
}

}  // namespace
}  // namespace tagcal
