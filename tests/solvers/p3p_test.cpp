#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "minimal_fixture.hpp"
#include "tagcal/solvers/p3p.hpp"

namespace tagcal {
namespace {

Three rays_of(const Three& points, const Pose& pose) {
  return {pose * points[0], pose * points[1], pose * points[2]};
}

void expect_sound(const Solutions<Pose, 4>& poses, const Three& points, const Three& rays) {
  for (const Pose& pose : poses) {
    EXPECT_NEAR(pose.rotation_matrix().determinant(), 1, 1e-12);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LT(((pose * points[k]).normalized() - rays[k].normalized()).norm(), 1e-9);
  }
}

double best_error(const Three& points, const Pose& truth) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& pose : p3p(points, rays_of(points, truth)))
    best = std::min(best, error_of(pose, truth, points));
  return best;
}

TEST(P3p, FindsTheTruthAndOnlySolutions) {
  for (const Views views : {Views::around, Views::usual, Views::far, Views::near}) {
    Random random(1, static_cast<std::uint64_t>(views));
    std::vector<double> errors;
    for (int i = 0; i < 20000; ++i) {
      const Three points = {random_vector(random), random_vector(random), random_vector(random)};
      const Pose truth = random_pose(random, place(views, random));
      const Three rays = rays_of(points, truth);
      expect_sound(p3p(points, rays), points, rays);
      errors.push_back(best_error(points, truth));
      ASSERT_LT(errors.back(), 1e-8) << i;
    }
    const auto missed =
        std::count_if(errors.begin(), errors.end(), [](double e) { return e > 1e-9; });
    RecordProperty("errors_" + std::to_string(static_cast<int>(views)), quantiles(errors));
    EXPECT_LE(missed, 2);  // within rounding of the danger cylinder
  }
}

TEST(P3p, FindsTheTruthInSymmetricViews) {
  Random random(2);
  const Three triangles[] = {{Vector3d(0, 0, 0), {1, 0, 0}, {1, 1, 0}},  // corners of a tag
                             {Vector3d(0, 0, 0), {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}};
  for (const Three& points : triangles)
    for (int i = 0; i < 500; ++i) {
      const Vector3d middle = i % 2 ? Vector3d((points[0] + points[1] + points[2]) / 3)
                                    : Vector3d((points[0] + points[2]) / 2);
      const Eigen::Quaterniond turn(
          Eigen::AngleAxisd(std::numbers::pi / 2 * static_cast<double>(random.index(4)),
                            Vector3d::UnitX()) *
          Eigen::AngleAxisd(std::numbers::pi / 2 * static_cast<double>(random.index(4)),
                            Vector3d::UnitZ()));
      const Pose truth(turn, Vector3d(0, 0, random.uniform(1.5, 9)) - turn * middle);
      EXPECT_LT(best_error(points, truth), 1e-9) << i;
    }
}

TEST(P3p, FindsAllThatAp3pFinds) {
  Random random(3);
  const cv::Matx33d identity = cv::Matx33d::eye();
  int found = 0, missed = 0;
  for (int i = 0; i < 2000; ++i) {
    const Three points = {random_vector(random), random_vector(random), random_vector(random)};
    const Pose truth = random_pose(random, place(Views::usual, random));
    std::vector<cv::Point3d> object;
    std::vector<cv::Point2d> image;
    for (const Vector3d& p : points) {
      const Vector3d x = truth * p;
      object.emplace_back(p.x(), p.y(), p.z());
      image.emplace_back(x.x() / x.z(), x.y() / x.z());
    }
    if (!std::all_of(points.begin(), points.end(),
                     [&](const Vector3d& p) { return (truth * p).z() > 0.1; }))
      continue;
    const auto ours = p3p(points, rays_of(points, truth));
    std::vector<cv::Vec3d> rotations, translations;
    cv::solveP3P(object, image, identity, cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_AP3P);
    for (std::size_t k = 0; k < rotations.size(); ++k) {
      const Pose theirs(exp_rotation({rotations[k][0], rotations[k][1], rotations[k][2]}),
                        {translations[k][0], translations[k][1], translations[k][2]});
      const bool sound = std::all_of(points.begin(), points.end(), [&](const Vector3d& p) {
        const Vector3d x = theirs * p;
        return x.z() > 1e-3 && (x.normalized() - (truth * p).normalized()).norm() < 1e-6;
      });
      if (!sound) continue;
      ++found;
      missed += std::none_of(ours.begin(), ours.end(), [&](const Pose& pose) {
        return error_of(pose, theirs, points) < 1e-4;
      });
    }
  }
  EXPECT_GT(found, 2000);
  EXPECT_EQ(missed, 0);
}

TEST(P3p, OnTheDangerCylinderTheTruthIsFoundToTheRootOfRounding) {
  Random random(4);
  std::vector<double> errors;
  for (int i = 0; i < 5000; ++i) {
    Three points;
    for (Vector3d& p : points) {
      const double a = random.uniform(0, 2 * std::numbers::pi);
      p = {std::cos(a), std::sin(a), 0};
    }
    if ((points[1] - points[0]).cross(points[2] - points[0]).norm() < 0.1) continue;
    const double a = random.uniform(0, 2 * std::numbers::pi);
    const Vector3d camera(std::cos(a), std::sin(a), random.uniform(1, 5));
    const Pose turn = random_pose(random, Vector3d::Zero());
    const Pose truth(turn.rotation(), turn * -camera);
    const Three rays = rays_of(points, truth);
    expect_sound(p3p(points, rays), points, rays);
    errors.push_back(best_error(points, truth));
  }
  RecordProperty("errors", quantiles(errors));
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 99 / 100], 1e-6);
  EXPECT_LT(errors.back(), 1e-4);  // where three solutions are nearly one
}

TEST(P3p, UnitAndOriginDoNotMatter) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    // Multiples of 2^-20, so that an offset of 2^20 keeps them exact.
    Three points;
    for (Vector3d& p : points) p = (in_cube(random, 1) * 0x1p20).array().round() * 0x1p-20;
    const Pose truth = random_pose(random, place(Views::around, random));
    const Three rays = rays_of(points, truth);
    const auto expected = p3p(points, rays);
    const double unit = std::pow(10, random.uniform(-9, 9));
    const Vector3d offset = 0x1p20 * Vector3d(1, -1, 1);
    Three scaled = points, moved = points;
    for (Vector3d& p : scaled) p *= unit;
    for (Vector3d& p : moved) p += offset;
    const auto from_scaled = p3p(scaled, rays), from_moved = p3p(moved, rays);
    ASSERT_EQ(from_scaled.size(), expected.size());
    ASSERT_EQ(from_moved.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_LT(angle_between_rad(from_scaled[k], expected[k]), 1e-9);
      EXPECT_LT((from_scaled[k] * scaled[0] / unit - expected[k] * points[0]).norm(), 1e-8);
      EXPECT_LT(angle_between_rad(from_moved[k], expected[k]), 1e-12);
      EXPECT_LT((from_moved[k] * moved[0] - expected[k] * points[0]).norm(), 1e-8);
    }
  }
}

TEST(P3p, RaysOfAnyLength) {
  const Three points = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0.2, 1, 0.3)};
  const Pose truth(Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1), Vector3d(0.1, -0.2, 3));
  for (const double length : {1e-300, 1e-160, 1.0, 1e160, 1e300}) {
    Three rays = rays_of(points, truth);
    for (Vector3d& ray : rays) ray *= length;
    EXPECT_FALSE(p3p(points, rays).empty()) << length;
    for (Vector3d& ray : rays) ray = -ray;
    for (const Pose& pose : p3p(points, rays)) EXPECT_GT(angle_between_rad(pose, truth), 0.1);
  }
}

TEST(P3p, NoneWherePointsOrRaysDoNotFixThePose) {
  const Three good = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0.2, 1, 0.3)};
  const Pose truth(Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1), Vector3d(0.1, -0.2, 3));
  const Three rays = rays_of(good, truth);
  ASSERT_FALSE(p3p(good, rays).empty());
  const Vector3d along(0.3, -0.7, 0.11);
  for (const double offset : {0.0, 1.0, 1e6}) {
    const Vector3d start = offset * Vector3d(1, 1 / 3.0, -0.7);
    const Three line = {start, start + along, start + 2.7 * along};
    EXPECT_TRUE(p3p(line, rays_of(line, truth)).empty()) << offset;
  }
  EXPECT_TRUE(p3p(Three{good[0], good[0], good[1]}, rays).empty());
  EXPECT_TRUE(p3p(Three{good[0], good[0], good[0]}, rays).empty());
  EXPECT_TRUE(p3p(good, Three{rays[0], rays[0], rays[0]}).empty());
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (std::size_t i = 0; i < 9; ++i) {
      Three wrong = good;
      wrong[i / 3][static_cast<Eigen::Index>(i % 3)] = bad;
      EXPECT_TRUE(p3p(wrong, rays).empty());
      wrong = rays;
      wrong[i / 3][static_cast<Eigen::Index>(i % 3)] = bad;
      EXPECT_TRUE(p3p(good, wrong).empty());
    }
  EXPECT_TRUE(p3p(good, Three{rays[0], Vector3d::Zero(), rays[2]}).empty());
}

RC_GTEST_PROP(P3p, BadInputGivesNoneOrRightAnswers, (std::uint64_t seed)) {
  Random random(seed);
  for (int i = 0; i < 300; ++i) {
    Three points, rays;
    for (Vector3d& p : points) p = bad_vector(random);
    for (Vector3d& ray : rays) ray = bad_vector(random);
    const double largest =
        std::max({points[0].stableNorm(), points[1].stableNorm(), points[2].stableNorm()});
    for (const Pose& pose : p3p(points, rays)) {
      RC_ASSERT(pose.matrix().allFinite());
      for (std::size_t k = 0; k < 3; ++k) {
        // The coordinates of a distant corner round away the part near the camera.
        const Vector3d x = pose * points[k];
        const double rounding =
            1e-14 * (largest + pose.translation().stableNorm()) / x.stableNorm();
        const Vector3d ray = rays[k] / rays[k].cwiseAbs().maxCoeff();
        RC_ASSERT((x.stableNormalized() - ray.normalized()).norm() < 1e-9 + rounding);
      }
    }
  }
}

}  // namespace
}  // namespace tagcal
