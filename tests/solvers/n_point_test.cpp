#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "n_point_fixture.hpp"
#include "tagcal/solvers/numeric/object_space.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr Setting kSettings[] = {
    {"space 4", 4, 1, 3},
    {"space 5", 5, 1, 3},
    {"space 6", 6, 1, 3},
    {"space 8", 8, 1, 3},
    {"space 30", 30, 1, 3},
    {"space 30 far", 30, 1, 100},
    {"plane 4", 4, 0, 3},
    {"plane 8", 8, 0, 3},
    {"plane 30 far", 30, 0, 30},
    {"frontal plane 4", 4, 0, 3, false, true},
    {"frontal plane 30", 30, 0, 4, false, true},
    {"thickness 1e-6", 8, 1e-6, 4},
    {"thickness 1e-4", 8, 1e-4, 4},
    {"thickness 1e-2", 8, 1e-2, 4},
    {"thickness 0.1", 8, 0.1, 4},
    {"frontal, thickness 1e-3", 8, 1e-3, 4, false, true},
    {"all around 4", 4, 1, 0.7, true},
    {"all around 8", 8, 1, 0.7, true},
    {"all around plane 6", 6, 0, 0.7, true},
};

TEST(NPoint, FindsTheTruthWithoutNoise) {
  for (const Setting& s : kSettings) {
    Random random(1);
    int missed = 0, not_first = 0;
    const int trials = s.num_points < 6 ? kTrials / 2 : kTrials;
    for (int i = 0; i < trials; ++i) {
      const Problem p = make_problem(s, 0, random);
      const auto poses = pnp(p.points, p.rays);
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << s.name << " " << i;
      const int place = place_of_truth(poses, p, 1e-6);
      missed += place < 0;
      not_first += place > 0;
    }
    EXPECT_EQ(missed, 0) << s.name;
    if (s.num_points >= 6) {
      EXPECT_EQ(not_first, 0) << s.name;
    }
  }
}

TEST(NPoint, ThreePointsGiveTheSolutionsOfP3P) {
  const Setting s{"three", 3, 1, 3};
  Random random(2);
  int missed = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Problem p = make_problem(s, 0, random);
    const auto poses = pnp(p.points, p.rays);
    ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << i;
    missed += place_of_truth(poses, p, 1e-5) < 0;
  }
  EXPECT_LE(missed, kTrials / 200);  // local descent misses 0.2 %
}

TEST(NPoint, TheFirstIsTheGlobalMinimumUnderNoise) {
  constexpr Setting kNoisy[] = {{"space 4", 4, 1, 3},           {"space 6", 6, 1, 3},
                                {"space 30", 30, 1, 5},         {"plane 4", 4, 0, 4},
                                {"plane 30", 30, 0, 10},        {"thickness 0.02", 8, 0.02, 6},
                                {"thickness 0.1", 8, 0.1, 30},  {"thickness 0.3", 8, 0.3, 10},
                                {"all around", 8, 1, 0.7, true}};
  for (const Setting& s : kNoisy) {
    Random random(3);
    for (int i = 0; i < kTrials / 20; ++i) {
      const Problem p = make_problem(s, 0.5 * kPx, random);
      const auto poses = pnp(p.points, p.rays);
      ASSERT_FALSE(poses.empty()) << s.name << " " << i;
      ASSERT_NO_FATAL_FAILURE(expect_proper(poses, p)) << s.name << " " << i;
      const auto e = object_space_error(p.points, p.rays);
      const auto value_of = [&](const Pose& pose) {
        const Vector9 r = columns_of(Quaterniond(e->rays_from_camera * pose.rotation_matrix() *
                                                 e->frame.plane_from_target.transpose()));
        return r.dot(e->omega * r);
      };
      const double first = value_of(poses.front());
      for (int k = 0; k < 30; ++k) {
        const auto minimum = descend(e->omega, random_rotation(random));
        if (!minimum) continue;
        Solutions<Pose, 4> pose;
        pose.push_back(e->camera_from_target(minimum->rotation));
        const bool in_front = largest_angle(pose.front(), p) < std::numbers::pi / 2;
        if (in_front) {
          EXPECT_LT(first, minimum->error + 1e-12) << s.name << " " << i;
        }
      }
    }
  }
}

TEST(NPoint, AgreesWithOpenCvsSqpnp) {
  constexpr Setting kBoth[] = {{"space 8", 8, 1, 3}, {"space 30", 30, 1, 5}, {"plane 8", 8, 0, 4}};
  for (const Setting& s : kBoth) {
    for (const double sigma : {0.0, 0.5 * kPx}) {
      Random random(4);
      double ours = 0, theirs = 0;
      for (int i = 0; i < 200; ++i) {
        const Problem p = make_problem(s, sigma, random);
        std::vector<cv::Point3d> points;
        std::vector<cv::Point2d> pixels;
        for (const Vector3d& x : p.points) points.emplace_back(x.x(), x.y(), x.z());
        for (const Vector3d& v : p.rays) pixels.emplace_back(v.x() / v.z(), v.y() / v.z());
        cv::Vec3d rotation, translation;
        cv::solvePnP(points, pixels, cv::Matx33d::eye(), cv::noArray(), rotation, translation,
                     false, cv::SOLVEPNP_SQPNP);
        const Pose peer(exp_rotation({rotation[0], rotation[1], rotation[2]}),
                        {translation[0], translation[1], translation[2]});
        const auto poses = pnp(p.points, p.rays);
        ASSERT_FALSE(poses.empty());
        const double peer_angle = largest_angle(peer, p);
        if (sigma == 0 && peer_angle < 1e-7) {
          EXPECT_LT(angle_between_rad(poses.front(), peer), 1e-5) << s.name << " " << i;
        }
        ours += largest_angle(poses.front(), p);
        theirs += peer_angle;
      }
      if (sigma > 0) {
        EXPECT_LT(ours, 1.03 * theirs) << s.name;
      }
    }
  }
}

TEST(NPoint, UnitAndOriginDoNotMatter) {
  Random random(5);
  for (const Setting& s : {Setting{"space", 8, 1, 3}, Setting{"plane", 6, 0, 3}}) {
    for (int i = 0; i < 200; ++i) {
      Problem p = make_problem(s, 0.5 * kPx, random);
      Vector3d centre = Vector3d::Zero();
      for (Vector3d& x : p.points) {
        x = (x * 0x1p20).array().round() * 0x1p-20;  // representable after the move, too
        centre += x / s.num_points;
      }
      const auto poses = pnp(p.points, p.rays);
      ASSERT_FALSE(poses.empty());
      const auto compare = [&](double unit, const Vector3d& offset) {
        std::vector<Vector3d> moved;
        for (const Vector3d& x : p.points) moved.push_back(unit * (x + offset));
        const auto again = pnp(moved, p.rays);
        ASSERT_EQ(again.size(), poses.size()) << s.name << " " << i << " " << unit;
        const Vector3d at = again.front() * Vector3d(unit * (centre + offset)) / unit;
        // The sum R x + t rounds at the size of the offset.
        EXPECT_LT((at - poses.front() * centre).norm(), 1e-9 + 1e-15 * offset.norm());
        EXPECT_LT(angle_between_rad(again.front(), poses.front()), 1e-9) << s.name << " " << i;
      };
      for (const double unit : {1e-9, 1e-3, 1e9}) compare(unit, Vector3d::Zero());
      compare(1, Vector3d(0x1p20, -0x1p20, 0x1p19));
    }
  }
}

TEST(NPoint, DerivativesAreThoseOfDifferences) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Problem p = make_problem({"space", 6, 1, 3}, 0.01, random);
    const auto e = object_space_error(p.points, p.rays);
    const Quaterniond q = random_rotation(random);
    const RotationExpansion at = expansion(e->omega, columns_of(q));
    const auto value = [&](const Vector3d& w) {
      return expansion(e->omega, columns_of(q * exp_rotation(w))).value;
    };
    constexpr double kStep = 1e-3;
    for (int a = 0; a < 3; ++a) {
      const Vector3d da = kStep * Vector3d::Unit(a);
      EXPECT_NEAR(at.gradient(a), (value(da) - value(-da)) / (2 * kStep), 1e-5);
      for (int b = 0; b < 3; ++b) {
        const Vector3d db = kStep * Vector3d::Unit(b);
        const double second = value(da + db) - value(da - db) - value(db - da) + value(-da - db);
        EXPECT_NEAR(at.hessian(a, b), second / (4 * kStep * kStep), 1e-5);
      }
    }
  }
}

TEST(NPoint, ErrorIsThatOfTheBestTranslation) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Problem p = make_problem({"around", 6, 0.5, 1, true}, 0.01, random);
    const auto e = object_space_error(p.points, p.rays);
    const Quaterniond q = random_rotation(random);
    const auto value = [&](const Vector3d& shift) {
      const Pose pose = e->camera_from_target(q);
      double sum = 0;
      for (std::size_t k = 0; k < p.points.size(); ++k)
        sum += p.rays[k].normalized().cross(pose * p.points[k] + shift).squaredNorm();
      return sum / (6 * e->frame.size * e->frame.size);
    };
    const Vector9 r = columns_of(q);
    EXPECT_NEAR(value(Vector3d::Zero()), r.dot(e->omega * r), 1e-12);
    EXPECT_GT(value(0.01 * random_vector(random)), value(Vector3d::Zero()));
  }
}

}  // namespace
}  // namespace tagcal
