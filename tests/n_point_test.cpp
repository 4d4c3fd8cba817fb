#include "tagcal/estimate/n_point.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "tagcal/estimate/object_space.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

#ifdef NDEBUG
constexpr int kTrials = 10000;
#else
constexpr int kTrials = 2000;  // the same draws, fewer of them
#endif

constexpr double kPx = 1.0 / 900;

// Points in a box of thickness x half its width, at a distance of so many half widths.
struct Setting {
  const char* name;
  int num_points;
  double thickness;
  double distance;
  bool all_around = false;  // seen in any direction, from inside too; else within 50 x 40 degrees
  bool frontal = false;     // else turned at random
};

struct Problem {
  std::vector<Vector3d> points, rays;
  Pose truth;
};

Quaterniond random_rotation(Random& random) {
  return Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized();
}

Vector3d normal_vector(Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

Pose random_pose(const Setting& s, Random& random) {
  if (s.all_around)
    return {random_rotation(random), s.distance * normal_vector(random).normalized()};
  const Vector3d along(random.uniform(-0.45, 0.45), random.uniform(-0.35, 0.35), 1);
  if (!s.frontal) return {random_rotation(random), s.distance * along};
  const Quaterniond facing(0, 1, 0, 0);  // z out of the board towards the camera
  return {exp_rotation(Vector3d(0, 0, random.uniform(-3, 3))) * facing, s.distance * along};
}

bool seen(const Setting& s, const Problem& p) {
  return std::all_of(p.points.begin(), p.points.end(), [&](const Vector3d& x) {
    const Vector3d y = p.truth * x;
    return y.norm() > 0.1 && (s.all_around || y.z() > 0.2);
  });
}

Problem make_problem(const Setting& s, double sigma, Random& random) {
  Problem p;
  do {
    p = {};
    for (int i = 0; i < s.num_points; ++i)
      p.points.push_back(
          {random.uniform(-1, 1), random.uniform(-1, 1), s.thickness * random.uniform(-1, 1)});
    p.truth = random_pose(s, random);
  } while (!seen(s, p));
  for (const Vector3d& x : p.points)
    p.rays.push_back(random.uniform(0.5, 2) *
                     ((p.truth * x).normalized() + sigma * normal_vector(random)));
  const Pose target_from_box(random_rotation(random), normal_vector(random));
  for (Vector3d& x : p.points) x = target_from_box * x;
  p.truth = p.truth * target_from_box.inverse();
  return p;
}

// The place of the truth among the poses; -1 where it is missing.
int place_of_truth(const Solutions<Pose, 4>& poses, const Problem& p, double tolerance) {
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (angle_between_rad(poses[i], p.truth) < tolerance &&
        distance_between_m(poses[i], p.truth) < tolerance * (1 + p.truth.translation().norm()))
      return static_cast<int>(i);
  return -1;
}

void expect_proper(const Solutions<Pose, 4>& poses, const Problem& p) {
  for (const Pose& pose : poses) {
    ASSERT_TRUE(pose.matrix().allFinite());
    ASSERT_NEAR(pose.rotation_matrix().determinant(), 1, 1e-12);
    for (std::size_t i = 0; i < p.points.size(); ++i)
      ASSERT_GT(p.rays[i].dot(pose * p.points[i]), 0);
  }
}

// The largest angle between a ray and the point that it should show.
double largest_angle(const Pose& pose, const Problem& p) {
  double largest = 0;
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    const Vector3d x = pose * p.points[i];
    largest = std::max(largest, std::atan2(p.rays[i].cross(x).norm(), p.rays[i].dot(x)));
  }
  return largest;
}

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
  EXPECT_LE(missed, kTrials / 200);  // by descent, so without a proof; 0.2 % are missed
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
        const Vector9 r = columns_of(
            Quaterniond(e->rays_from_camera * pose.rotation_matrix() * e->frame.axes.transpose()));
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
    EXPECT_GT(value(0.01 * normal_vector(random)), value(Vector3d::Zero()));
  }
}

TEST(NPoint, NoneWithoutEnoughPoints) {
  Random random(8);
  const Problem p = make_problem({"space", 8, 1, 3}, 0, random);
  for (std::size_t n = 0; n < 3; ++n)
    EXPECT_TRUE(pnp(std::span(p.points).first(n), std::span(p.rays).first(n)).empty());
}

// Spoils a problem in one of the ways that inputs go bad; true where no pose can be right.
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
      const Vector3d a = p.points[0], d = normal_vector(random);
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

// Inputs that are odd, but fix a pose.
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

TEST(NPoint, BadInputGivesNone) {
  Random random(9);
  for (int i = 0; i < kTrials; ++i) {
    const int n = 3 + static_cast<int>(random.index(10));
    Problem p = make_problem({"any", n, i % 2 ? 1.0 : 0.0, 3}, 0, random);
    ASSERT_TRUE(spoil(p, static_cast<std::size_t>(i) % 8, random));
    EXPECT_TRUE(pnp(p.points, p.rays).empty()) << i % 8 << ", " << n << " points";
  }
}

TEST(NPoint, OddInputGivesTheRightPose) {
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

TEST(NPoint, RandomRaysNeverGiveAnImproperPose) {
  Random random(11);
  for (int i = 0; i < kTrials / 2; ++i) {
    const int n = 3 + static_cast<int>(random.index(6));
    Problem p = make_problem({"any", n, i % 2 ? 1.0 : 0.0, 3}, 0, random);
    for (Vector3d& v : p.rays) v = normal_vector(random);
    ASSERT_NO_FATAL_FAILURE(expect_proper(pnp(p.points, p.rays), p)) << i;
  }
}

}  // namespace
}  // namespace tagcal
