#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numbers>
#include <vector>

#include "batch_fixture.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

bool same_bits(const Result& a, std::size_t i, const Result& b, std::size_t k) {
  return std::memcmp(&a.pixels[i], &b.pixels[k], sizeof(Vector2d)) == 0 && a.valid[i] == b.valid[k];
}

// Which points are hard: each special in one coordinate, or in all.
std::vector<Vector3d> special_points() {
  std::vector<Vector3d> points;
  const double values[] = {0.0,    -0.0,   1.0,     -1.0,  kNaN,  kInfinity, -kInfinity,
                           1e-320, 1e-200, -1e-160, 1e160, 1e200, 1e307};
  for (const double x : values)
    for (const double y : values)
      for (const double z : values) points.emplace_back(x, y, z);
  return points;
}

// How far rounding may move the pixel: a few ulp of its terms. `spread`: what the terms of the
// distortion add up to, more than the result where they cancel.
double spread(const Perspective& lens, const Vector3d& x) {
  const auto& p = lens.parameters();
  const double s = x.head<2>().squaredNorm() / (x.z() * x.z()), r = std::sqrt(s);
  const auto sum = [s](double a, double b, double c) {
    return 1 + s * (std::abs(a) + s * (std::abs(b) + s * std::abs(c)));
  };
  const double denominator = std::abs(1 + s * (p[9] + s * (p[10] + s * p[11])));
  const double cancelled = sum(p[9], p[10], p[11]) / denominator;
  return std::max(p[0], p[1]) * (r * sum(p[4], p[5], p[8]) / denominator * cancelled +
                                 3 * s * (std::abs(p[6]) + std::abs(p[7])));
}
double spread(const Fisheye& lens, const Vector3d& x) {
  const auto& p = lens.parameters();
  const double theta = std::atan2(std::hypot(x.x(), x.y()), x.z()), s = theta * theta;
  return std::max(p[0], p[1]) * theta *
         (1 +
          s * (std::abs(p[4]) + s * (std::abs(p[5]) + s * (std::abs(p[6]) + s * std::abs(p[7])))));
}
double spread(const Parallel& lens, const Vector3d& x) {
  const auto& p = lens.parameters();
  return std::max(p[0], p[1]) * (1 + std::abs(p[4]) + std::abs(p[5])) * x.norm();
}

// (X, Y) over a denominator whose terms cancel behind the camera.
double spread(const DoubleSphere& lens, const Vector3d& x) {
  const auto& p = lens.parameters();
  const double d1 = x.norm(), z = p[4] * d1 + x.z(), d2 = std::hypot(x.x(), x.y(), z);
  const double terms = p[5] * d2 + std::abs(p[4]) * d1 + std::abs(x.z());
  const double sum = p[5] * d2 + (1 - p[5]) * z;
  return std::max(p[0], p[1]) * x.head<2>().norm() / sum * (1 + terms / sum);
}
double spread(const ExtendedUnified& lens, const Vector3d& x) {
  const auto& p = lens.parameters();
  const double d = std::hypot(std::sqrt(p[5]) * x.x(), std::sqrt(p[5]) * x.y(), x.z());
  const double terms = p[4] * d + std::abs(x.z()), sum = p[4] * d + (1 - p[4]) * x.z();
  return std::max(p[0], p[1]) * x.head<2>().norm() / sum * (1 + terms / sum);
}

double rounding_px(const Lens& lens, const Vector3d& x) {
  const std::span<const double> p = parameters(lens);
  return 8 * kEpsilon *
         (std::abs(p[2]) + std::abs(p[3]) +
          std::visit([&](const auto& l) { return spread(l, x); }, lens));
}

template <typename L>
class BatchProject : public testing::Test {};
using BatchLenses = testing::Types<Perspective, Fisheye, Parallel, DoubleSphere, ExtendedUnified>;
TYPED_TEST_SUITE(BatchProject, BatchLenses);

TYPED_TEST(BatchProject, AgreesWithOnePointToRounding) {
  Random random(1);
  for (const ProjectKernels* kernels : all_kernels()) {
    for (const Lens& lens : lenses<TypeParam>(2, 100)) {
      std::vector<Vector3d> points;
      for (int i = 0; i < 103; ++i) points.push_back(some_point(lens, random));
      const Result batch = run(*kernels, lens, Pose(), points);
      std::size_t count = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const auto one = project(lens, points[i]);
        ASSERT_EQ(batch.valid[i], one.has_value() ? 1 : 0) << points[i].transpose();
        count += one.has_value();
        if (!one) {
          EXPECT_TRUE(std::isnan(batch.pixels[i].x()) && std::isnan(batch.pixels[i].y()));
        } else {
          EXPECT_LE((batch.pixels[i] - *one).norm(), rounding_px(lens, points[i]));
        }
      }
      EXPECT_EQ(batch.count, count);
    }
  }
}

TYPED_TEST(BatchProject, AgreesWithOnePointThroughAPose) {
  Random random(3);
  for (const ProjectKernels* kernels : all_kernels()) {
    for (const Lens& lens : lenses<TypeParam>(4, 30)) {
      const Pose pose = some_pose(random);
      std::vector<Vector3d> points;
      for (int i = 0; i < 101; ++i) points.push_back(pose.inverse() * some_point(lens, random));
      const Result batch = run(*kernels, lens, pose, points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3d x = pose * points[i];
        PointJacobian j;
        const auto one = std::visit([&](const auto& l) { return l.project(x, &j, nullptr); }, lens);
        ASSERT_EQ(batch.valid[i], one.has_value() ? 1 : 0);
        if (!one) continue;
        const double moved = 8 * kEpsilon * (points[i].norm() + pose.translation().norm());
        EXPECT_LE((batch.pixels[i] - *one).norm(), rounding_px(lens, x) + moved * j.norm());
      }
    }
  }
}

TYPED_TEST(BatchProject, SpecialValuesAreDecidedAsOneByOne) {
  const std::vector<Vector3d> points = special_points();
  for (const ProjectKernels* kernels : all_kernels()) {
    for (const Lens& lens : lenses<TypeParam>(5, 3)) {
      const Result batch = run(*kernels, lens, Pose(), points);
      const Result rows = run(*kernels, lens, Pose(), points, every_parameter(lens), true);
      for (std::size_t i = 0; i < points.size(); ++i) {
        // The pose may make NaN of infinity: by the same formula.
        const Vector3d x = Eigen::Matrix3d::Identity() * points[i] + Vector3d::Zero();
        const auto one = project(lens, x);
        ASSERT_EQ(batch.valid[i], one.has_value() ? 1 : 0) << points[i].transpose();
        EXPECT_EQ(rows.valid[i], batch.valid[i]);
        const double size = x.cwiseAbs().maxCoeff();
        if (!one) {
          EXPECT_TRUE(rows.pose_rows(i).array().isNaN().all());
          EXPECT_TRUE(rows.parameter_rows(i).array().isNaN().all());
        } else if (one->norm() < 1e6 && size > 1e-200 && size < 1e300) {  // no overflow
          EXPECT_TRUE(rows.pose_rows(i).allFinite()) << points[i].transpose();
          EXPECT_TRUE(rows.parameter_rows(i).allFinite()) << points[i].transpose();
        }
        if (!one) {
          EXPECT_TRUE(std::isnan(batch.pixels[i].x()) && std::isnan(batch.pixels[i].y()));
        } else if (one->norm() < 1e6) {
          EXPECT_LT((batch.pixels[i] - *one).norm(), 1e-9) << points[i].transpose();
        }
      }
    }
  }
}

TYPED_TEST(BatchProject, APointsResultDoesNotDependOnItsPlaceNorOnWhatIsAsked) {
  Random random(6);
  for (const ProjectKernels* kernels : all_kernels()) {
    const Lens lens = random_lens<TypeParam>(random);
    const Pose pose = some_pose(random);
    std::vector<Vector3d> points;
    for (int i = 0; i < 40; ++i) points.push_back(pose.inverse() * some_point(lens, random));
    points[7] = {kNaN, 1, 1};
    const Result whole = run(*kernels, lens, pose, points, every_parameter(lens), true);
    for (std::size_t begin = 0; begin < 8; ++begin) {
      for (std::size_t size = 0; size <= 17; ++size) {
        const std::span<const Vector3d> part(points.data() + begin, size);
        const Result pixels = run(*kernels, lens, pose, part);
        const Result rows = run(*kernels, lens, pose, part, every_parameter(lens), true);
        EXPECT_EQ(pixels.count, rows.count);
        for (std::size_t i = 0; i < size; ++i) {
          EXPECT_TRUE(same_bits(rows, i, whole, begin + i));
          EXPECT_TRUE((rows.pose_rows(i).array() == whole.pose_rows(begin + i).array()).all() ||
                      !rows.valid[i]);
          EXPECT_TRUE(
              (rows.parameter_rows(i).array() == whole.parameter_rows(begin + i).array()).all() ||
              !rows.valid[i]);
          // A lens without distortion leaves terms out: equal values, maybe -0 for 0.
          EXPECT_TRUE(pixels.pixels[i] == rows.pixels[i] || !pixels.valid[i]);
        }
      }
    }
  }
}

TEST(BatchFisheye, AngleIsRightToTheLastBits) {
  // u = theta for a point beside the axis.
  const Fisheye lens({1, 1, 0, 0});
  Random random(12);
  std::vector<Vector3d> points;
  std::vector<long double> angles;
  for (int i = 0; i < 20001; ++i) {
    const double theta =
        i % 2 ? std::numbers::pi * random.uniform() : std::pow(10.0, random.uniform(-12, 0));
    points.push_back(random.uniform(0.01, 100) * Vector3d(std::sin(theta), 0, std::cos(theta)));
    angles.push_back(std::atan2(static_cast<long double>(points.back().x()),
                                static_cast<long double>(points.back().z())));
  }
  for (const ProjectKernels* kernels : all_kernels()) {
    const Result batch = run(*kernels, lens, Pose(), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(batch.valid[i]);
      EXPECT_LE(std::abs(batch.pixels[i].x() - angles[i]), 1e-15L * angles[i]) << angles[i];
    }
  }
}

TEST(BatchDispatch, TakesAvx2WhereTheProcessorHasIt) {
  const ProjectKernels& expected = has_avx2() ? kAvx2Kernels : kPortableKernels;
  EXPECT_EQ(fastest_kernels().pixels[kPinhole], expected.pixels[kPinhole]);
  EXPECT_EQ(fastest_kernels().sums_pose[kFisheye], expected.sums_pose[kFisheye]);
}

}  // namespace
}  // namespace tagcal
