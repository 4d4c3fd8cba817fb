#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "minimal_fixture.hpp"
#include "tagcal/solvers/p4pf.hpp"

namespace tagcal {
namespace {

FourPixels pixels_of(const Four& points, const Pose& pose, double focal_px) {
  FourPixels pixels;
  for (std::size_t k = 0; k < 4; ++k) pixels[k] = focal_px * (pose * points[k]).hnormalized();
  return pixels;
}

bool all_in_front(const Four& points, const Pose& pose) {
  return std::all_of(points.begin(), points.end(),
                     [&](const Vector3d& p) { return (pose * p).z() > 0.1; });
}

Four random_four(Random& random) {
  return {in_cube(random, 1), in_cube(random, 1), in_cube(random, 1), in_cube(random, 1)};
}

const Four kRegular = {Vector3d(1, 1, 1), Vector3d(1, -1, -1), Vector3d(-1, 1, -1),
                       Vector3d(-1, -1, 1)};

double best_error(const Solutions<PoseAndFocal, 6>& solutions, const Pose& truth, double focal_px,
                  const Four& points) {
  double best = std::numeric_limits<double>::infinity();
  for (const PoseAndFocal& s : solutions)
    best = std::min(
        best, error_of(s.camera_from_target, truth, points) + std::abs(s.focal_px / focal_px - 1));
  return best;
}

void expect_sound(const Solutions<PoseAndFocal, 6>& solutions, const Four& points) {
  for (const PoseAndFocal& s : solutions) {
    EXPECT_NEAR(s.camera_from_target.rotation_matrix().determinant(), 1, 1e-12);
    EXPECT_TRUE(s.focal_px > 0 && std::isfinite(s.focal_px));
    for (const Vector3d& p : points) EXPECT_GT((s.camera_from_target * p).z(), 0);
  }
}

// Cramer-Rao bound of the standard deviation of log f.
double bound_of_log_focal(const Four& points, const Pose& pose, double focal_px, double sigma_px) {
  Eigen::Matrix<double, 8, 7> j;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const Vector3d turned = pose.rotation() * points[static_cast<std::size_t>(k)];
    const Vector3d x = turned + pose.translation();
    Eigen::Matrix<double, 2, 3> d;
    d << 1, 0, -x.x() / x.z(), 0, 1, -x.y() / x.z();
    d *= focal_px / x.z();
    j.block<2, 3>(2 * k, 0) = -d * cross_matrix(turned);
    j.block<2, 3>(2 * k, 3) = d;
    j.block<2, 1>(2 * k, 6) = focal_px * x.hnormalized();
  }
  return sigma_px * std::sqrt((j.transpose() * j).inverse()(6, 6));
}

TEST(P4pf, FindsTheTruthWithoutNoise) {
  for (const Views views : {Views::usual, Views::far}) {
    Random random(6, static_cast<std::uint64_t>(views));
    std::vector<double> errors;
    for (int i = 0; i < 20000; ++i) {
      const Four points = random_four(random);  // thin ones too: no lower bound of the volume
      Vector3d t = place(views, random);
      if (views == Views::far) t /= 20;
      const Pose truth = random_pose(random, t);
      const double focal_px = random.uniform(300, 3000);
      if (!all_in_front(points, truth)) continue;
      const auto solutions = p4pf(points, pixels_of(points, truth, focal_px));
      expect_sound(solutions, points);
      errors.push_back(best_error(solutions, truth, focal_px, points));
    }
    const auto missed =
        std::count_if(errors.begin(), errors.end(), [](double e) { return !(e < 1e-6); });
    RecordProperty("errors_" + std::to_string(static_cast<int>(views)), quantiles(errors));
    EXPECT_LE(static_cast<double>(missed), 2e-4 * static_cast<double>(errors.size()));
  }
}

TEST(P4pf, FindsTheTruthInSymmetricViews) {
  Random random(7);
  const Four corner = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)};
  for (int i = 0; i < 6000; ++i) {
    const Eigen::Vector3d axis = Vector3d::Unit(static_cast<Eigen::Index>(random.index(3)));
    const double quarter = std::numbers::pi / 2 * static_cast<double>(random.index(4));
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(quarter, axis));
    const double z = random.uniform(3, 8);
    const Pose centred(turn, Vector3d(0, 0, z));
    const Pose beside(turn, Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), z));
    for (const Pose& truth : {centred, beside})
      EXPECT_LT(best_error(p4pf(kRegular, pixels_of(kRegular, truth, 900)), truth, 900, kRegular),
                1e-6)
          << i;
    EXPECT_LT(best_error(p4pf(corner, pixels_of(corner, beside, 900)), beside, 900, corner), 1e-6)
        << i;
  }
}

// Two points at the principal point, the other two in orthogonal directions from it: one of the
// equations degenerates.
TEST(P4pf, NoneWhereAnEquationIsLost) {
  const Four corner = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)};
  const Pose truth(Eigen::Quaterniond::Identity(), Vector3d(0, 0, 5));
  EXPECT_TRUE(p4pf(corner, pixels_of(corner, truth, 900)).empty());
}

TEST(P4pf, IsNearTheTruthAtATenthOfAPixel) {
  Random random(8);
  int trials = 0, missed = 0;
  std::vector<double> errors;
  while (trials < 5000) {
    const Pose truth =
        random_pose(random, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(3, 8)});
    const double sd = bound_of_log_focal(kRegular, truth, 900, 0.1);
    if (sd > 0.03) continue;  // not observable well enough
    ++trials;
    FourPixels pixels = pixels_of(kRegular, truth, 900);
    for (Vector2d& pixel : pixels) pixel += 0.1 * Vector2d(random.normal(), random.normal());
    const auto solutions = p4pf(kRegular, pixels);
    expect_sound(solutions, kRegular);
    missed += !(best_error(solutions, truth, 900, kRegular) < std::max(0.1, 10 * sd));
    double nearest = std::numeric_limits<double>::infinity();
    for (const PoseAndFocal& s : solutions)
      nearest = std::min(nearest, std::abs(std::log(s.focal_px / 900)));
    errors.push_back(nearest / sd);
  }
  RecordProperty("errors_in_sd", quantiles(errors));
  EXPECT_LE(missed, 10);  // 0.2 %
  // The median of a normal error is 0.67 standard deviations: the solver is nearly efficient.
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.8);
}

TEST(P4pf, UnitAndOriginDoNotMatter) {
  Random random(9);
  for (int i = 0; i < 2000; ++i) {
    Four points = random_four(random);
    for (Vector3d& p : points) p = (p * 0x1p20).array().round() * 0x1p-20;
    const Pose truth = random_pose(random, {0.3, -0.2, random.uniform(3, 8)});
    const FourPixels pixels = pixels_of(points, truth, 900);
    const double unit = std::pow(10, random.uniform(-9, 9));
    Four scaled = points, moved = points;
    for (Vector3d& p : scaled) p *= unit;
    for (Vector3d& p : moved) p += 0x1p20 * Vector3d(1, -1, 1);
    const auto expected = p4pf(points, pixels);
    const auto from_scaled = p4pf(scaled, pixels), from_moved = p4pf(moved, pixels);
    ASSERT_EQ(from_scaled.size(), expected.size()) << i;
    ASSERT_EQ(from_moved.size(), expected.size()) << i;
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Pose &a = expected[k].camera_from_target, &b = from_scaled[k].camera_from_target,
                 &c = from_moved[k].camera_from_target;
      EXPECT_LT(angle_between_rad(a, b) + angle_between_rad(a, c), 1e-7) << i;
      EXPECT_LT((b * scaled[0] / unit - a * points[0]).norm(), 1e-6) << i;
      EXPECT_LT((c * moved[0] - a * points[0]).norm(), 1e-6) << i;
      EXPECT_NEAR(from_scaled[k].focal_px / expected[k].focal_px, 1, 1e-7) << i;
    }
  }
}

TEST(P4pf, NoneWherePointsOrPixelsDoNotFixThePose) {
  const Pose truth(Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1), Vector3d(0.1, -0.2, 5));
  const FourPixels pixels = pixels_of(kRegular, truth, 900);
  ASSERT_FALSE(p4pf(kRegular, pixels).empty());
  for (const double offset : {0.0, 1.0, 1e6}) {
    const Vector3d start = offset * Vector3d(1, 1 / 3.0, -0.7);
    const Vector3d u(0.3, -0.7, 0.11), v(1, 0.2, 0.37);
    const Four plane = {start, start + u, start + v, start + 0.7 * u + 1.3 * v};
    EXPECT_TRUE(p4pf(plane, pixels).empty()) << offset;
    const Four line = {start, start + u, start + 0.3 * u, start + 1.7 * u};
    EXPECT_TRUE(p4pf(line, pixels).empty()) << offset;
  }
  EXPECT_TRUE(p4pf(Four{kRegular[0], kRegular[0], kRegular[1], kRegular[2]}, pixels).empty());
  EXPECT_TRUE(p4pf(kRegular, FourPixels{pixels[0], pixels[0], pixels[0], pixels[0]}).empty());
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (std::size_t i = 0; i < 4; ++i) {
      Four points = kRegular;
      points[i].y() = bad;
      EXPECT_TRUE(p4pf(points, pixels).empty());
      FourPixels wrong = pixels;
      wrong[i].x() = bad;
      EXPECT_TRUE(p4pf(kRegular, wrong).empty());
    }
}

void expect_finite_answers_in_front(std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < 300; ++i) {
    Four points;
    FourPixels pixels;
    for (Vector3d& p : points) p = bad_vector(random);
    for (Vector2d& pixel : pixels) pixel = bad_vector(random).head<2>();
    for (const PoseAndFocal& s : p4pf(points, pixels)) {
      RC_ASSERT(s.camera_from_target.matrix().allFinite());
      RC_ASSERT(s.focal_px > 0 && std::isfinite(s.focal_px));
      for (const Vector3d& p : points) RC_ASSERT((s.camera_from_target * p).z() > 0);
    }
  }
}

RC_GTEST_PROP(P4pf, BadInputGivesNoneOrFiniteAnswersInFront, (std::uint64_t seed)) {
  expect_finite_answers_in_front(seed);
}

// One of its points is so far away that the translation overflows.
RC_GTEST_PROP(P4pf, AnOverflowIsNoAnswer, ()) { expect_finite_answers_in_front(5000242866); }

}  // namespace
}  // namespace tagcal
