#include "tagcal/estimate/minimal.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "tagcal/estimate/real_roots.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using Three = std::array<Vector3d, 3>;
using Four = std::array<Vector3d, 4>;
using FourPixels = std::array<Vector2d, 4>;

Vector3d normal_vector(Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}

Vector3d in_cube(Random& random, double half_side) {
  return {random.uniform(-half_side, half_side), random.uniform(-half_side, half_side),
          random.uniform(-half_side, half_side)};
}

Pose random_pose(Random& random, const Vector3d& translation) {
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

// Shares of the errors that the 50th, 99th and 99.9th of a hundred stay below, for the log.
std::string quantiles(std::vector<double> errors) {
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

// How a random problem is made: all around the camera (fisheye), usual views, far away, very near.
enum class Views { around, usual, far, near };

Vector3d place(Views views, Random& random) {
  if (views == Views::around) return 3 * normal_vector(random);
  if (views == Views::near) return 0.5 * normal_vector(random);
  const double scale = views == Views::far ? 1000 : random.uniform(3, 8);
  return scale * Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1);
}

TEST(P3p, FindsTheTruthAndOnlySolutions) {
  for (const Views views : {Views::around, Views::usual, Views::far, Views::near}) {
    Random random(1, static_cast<std::uint64_t>(views));
    std::vector<double> errors;
    for (int i = 0; i < 20000; ++i) {
      const Three points = {normal_vector(random), normal_vector(random), normal_vector(random)};
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
    const Three points = {normal_vector(random), normal_vector(random), normal_vector(random)};
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

// The standard deviation of log f that the best estimator has.
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
// equations is lost.
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
  // The median of a normal error is 0.67 standard deviations: the solutions lose little.
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

// Numbers as bad input has them: few different ones, so that points coincide and line up.
double bad_number(Random& random) {
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

Vector3d bad_vector(Random& random) {
  return {bad_number(random), bad_number(random), bad_number(random)};
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
        // A far corner of the target rounds away what is near the camera.
        const Vector3d x = pose * points[k];
        const double rounding =
            1e-14 * (largest + pose.translation().stableNorm()) / x.stableNorm();
        const Vector3d ray = rays[k] / rays[k].cwiseAbs().maxCoeff();
        RC_ASSERT((x.stableNormalized() - ray.normalized()).norm() < 1e-9 + rounding);
      }
    }
  }
}

RC_GTEST_PROP(P4pf, BadInputGivesNoneOrFiniteAnswersInFront, (std::uint64_t seed)) {
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

TEST(RealRoots, AreAllFound) {
  Random random(10);
  for (int i = 0; i < 20000; ++i) {
    FixedPolynomial<6> p{{1}};
    std::vector<double> truth;
    // Three pairs: real, complex.
    FixedPolynomial<0> one{{random.uniform(0.5, 2)}};
    const auto pair = [&] {
      const double a = random.uniform(-12, 12), b = random.uniform(-12, 12);
      if (random.uniform() < 0.4) return FixedPolynomial<2>{{a * a + b * b, -2 * a, 1}};
      truth.insert(truth.end(), {a, b});
      return FixedPolynomial<2>{{a * b, -a - b, 1}};
    };
    const auto first = pair(), second = pair(), third = pair();
    p = one * first * second * third;
    const auto found = roots_and_near_roots(p, -10, 11);
    for (const double root : truth) {
      const bool inside = root > -10 && root < 11;
      EXPECT_TRUE(!inside || std::any_of(found.begin(), found.end(),
                                         [root](double x) { return std::abs(x - root) < 1e-3; }))
          << i << " " << root;
    }
  }
}

}  // namespace
}  // namespace tagcal
