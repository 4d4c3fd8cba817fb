#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "lenses.hpp"
#include "tagcal/camera/camera.hpp"
#include "tagcal/camera/lenses/polynomial.hpp"
#include "tagcal/error.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

template <typename L>
class LensContract : public testing::Test {};
using Lenses = testing::Types<Perspective, Fisheye, Parallel, DoubleSphere, ExtendedUnified>;
TYPED_TEST_SUITE(LensContract, Lenses);

TYPED_TEST(LensContract, RayInvertsProjectOverTheWholeDomain) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const auto lens = random_lens<TypeParam>(random);
    const Vector3d x = point_inside(lens, random);
    const std::optional<Vector2d> pixel = lens.project(x);
    ASSERT_TRUE(pixel.has_value());
    if (pixel->norm() > 3e4) continue;  // in no image: beside a pole of a rational model
    const std::optional<Ray> ray = lens.ray_in_camera(*pixel);
    ASSERT_TRUE(ray.has_value()) << i;
    EXPECT_NEAR(ray->direction.norm(), 1, 1e-15);
    const double along = (x - ray->origin).dot(ray->direction);
    const std::optional<Vector2d> again = lens.project(ray->origin + along * ray->direction);
    ASSERT_TRUE(again.has_value()) << i;
    EXPECT_LT((*again - *pixel).norm(), 1e-9) << i;
  }
}

TYPED_TEST(LensContract, JacobiansAgreeWithDifferences) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const auto lens = random_lens<TypeParam>(random);
    const Vector3d x = 0.97 * point_inside(lens, random);
    PointJacobian by_point;
    typename TypeParam::ParameterJacobian by_parameters;
    const auto pixel = lens.project(x, &by_point, &by_parameters);
    ASSERT_TRUE(pixel.has_value());
    if (pixel->norm() > 3e4) continue;  // beside a pole of a rational model
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-6 * x.norm();
      const auto ahead = lens.project(x + h * Vector3d::Unit(k));
      const auto behind = lens.project(x - h * Vector3d::Unit(k));
      if (!ahead || !behind) continue;  // at the border of the domain
      const Vector2d difference = (*ahead - *behind) / (2 * h);
      EXPECT_LT((difference - by_point.col(k)).norm(), 1e-5 * (1 + by_point.norm()))
          << i << " " << k;
    }
    for (int k = 0; k < TypeParam::kNumParameters; ++k) {
      auto moved = lens.parameters();
      const double h = 1e-6 * std::max(1.0, std::abs(moved[k]));
      moved[k] += h;
      const auto ahead = TypeParam(moved).project(x);
      moved[k] -= 2 * h;
      const auto behind = TypeParam(moved).project(x);
      if (!ahead || !behind) continue;
      const Vector2d difference = (*ahead - *behind) / (2 * h);
      EXPECT_LT((difference - by_parameters.col(k)).norm(), 1e-6 * (1 + by_parameters.norm()))
          << i << " " << TypeParam::kParameters[k].name;
    }
  }
}

TYPED_TEST(LensContract, WhatIsNotFiniteHasNoValue) {
  Random random(4);
  const auto lens = random_lens<TypeParam>(random);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(lens.project({nan, 0.1, 1}).has_value());
  EXPECT_FALSE(lens.project({0.1, nan, 1}).has_value());
  EXPECT_FALSE(lens.project({0.1, 0.1, nan}).has_value());
  EXPECT_FALSE(lens.project({infinity, 0.1, 1}).has_value());
  EXPECT_FALSE(lens.project({0.1, -infinity, 1}).has_value());
  EXPECT_FALSE(lens.ray_in_camera({nan, 0}).has_value());
  EXPECT_FALSE(lens.ray_in_camera({0, infinity}).has_value());
  auto parameters = lens.parameters();
  parameters[1] = std::nan("");
  EXPECT_THROW(TypeParam{parameters}, Error);
  parameters[1] = -3;
  EXPECT_THROW(TypeParam{parameters}, Error);
}

cv::Mat1d coefficients(std::span<const double> parameters) {
  cv::Mat1d d(1, static_cast<int>(parameters.size()) - 4);
  for (int i = 0; i < d.cols; ++i) d(0, i) = parameters[static_cast<std::size_t>(i) + 4];
  return d;
}

TEST(Perspective, AgreesWithOpenCV) {
  Random random(5);
  for (int i = 0; i < 10000; ++i) {
    const auto lens = random_lens<Perspective>(random);
    const Vector3d x = point_inside(lens, random);
    if (lens.project(x)->norm() > 3e4) continue;  // beside a pole of a rational model
    const auto& p = lens.parameters();
    const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    std::vector<cv::Point2d> theirs;
    cv::projectPoints(std::vector<cv::Point3d>{{x.x(), x.y(), x.z()}}, cv::Vec3d(), cv::Vec3d(), k,
                      coefficients(p), theirs);
    EXPECT_LT((*lens.project(x) - Vector2d(theirs[0].x, theirs[0].y)).norm(), 1e-9);
  }
}

TEST(Fisheye, AgreesWithOpenCVInFrontOfTheCamera) {
  Random random(6);
  for (int i = 0; i < 10000; ++i) {
    const auto lens = random_lens<Fisheye>(random);
    const Vector3d x = point_inside(lens, random);
    if (x.z() < 0.01 * x.norm()) continue;  // OpenCV divides by z
    const auto& p = lens.parameters();
    const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    std::vector<cv::Point2d> theirs;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{{x.x(), x.y(), x.z()}}, theirs, cv::Vec3d(),
                               cv::Vec3d(), k, coefficients(p));
    EXPECT_LT((*lens.project(x) - Vector2d(theirs[0].x, theirs[0].y)).norm(), 1e-8);
  }
}

TEST(Perspective, NothingIsSeenBehindTheCameraOrBeyondTheFold) {
  // k1 = -0.3 folds at r = 1 / sqrt(0.9) = 1.054 (limits.md, M1).
  const Perspective lens({600, 600, 640, 400, -0.3});
  EXPECT_NEAR(lens.max_radius(), 1 / std::sqrt(0.9), 1e-15);
  EXPECT_TRUE(lens.project({1.0540, 0, 1}).has_value());
  EXPECT_FALSE(lens.project({1.0541, 0, 1}).has_value());
  EXPECT_FALSE(lens.project({1.3, 0, 1}).has_value());
  EXPECT_FALSE(lens.project({0, 0, 0}).has_value());
  EXPECT_FALSE(lens.project({0.1, 0.1, 0}).has_value());
  EXPECT_FALSE(lens.project({0.1, 0.1, -1}).has_value());
  // No ray beyond the image of the fold, 0.7027 * 600 px from the centre.
  const double fold = 600 * (1.0540925 - 0.3 * std::pow(1.0540925, 3));
  EXPECT_TRUE(lens.ray_in_camera({640 + fold - 0.01, 400}).has_value());
  EXPECT_FALSE(lens.ray_in_camera({640 + fold + 0.01, 400}).has_value());
  EXPECT_EQ(pinhole(1, 1, 0, 0).max_radius(), INFINITY);
}

TEST(Perspective, DomainStopsAtAPoleOfTheRationalModel) {
  const Perspective lens({600, 600, 640, 400, 0, 0, 0, 0, 0, -0.25, 0, 0});  // D = 1 - s / 4
  EXPECT_NEAR(lens.max_radius(), 2, 1e-12);
}

TEST(Perspective, DistortionIsOneToOneInItsDomain) {
  Random random(7);
  for (int i = 0; i < 5000; ++i) {
    const auto lens = random_lens<Perspective>(random);
    PointJacobian j;
    ASSERT_TRUE(lens.project(point_inside(lens, random), &j, nullptr).has_value());
    const Eigen::Matrix2d m =
        Vector2d(1 / lens.parameters()[0], 1 / lens.parameters()[1]).asDiagonal() * j.leftCols<2>();
    EXPECT_GT(m.determinant(), 0);
    EXPECT_GT(m.trace(), 0);
  }
}

// The least eigenvalue of the distortion's Jacobian at a point of the normalised plane.
double least_stretch(const Perspective& lens, const Vector2d& at) {
  PointJacobian j;
  EXPECT_TRUE(lens.project(at.homogeneous(), &j, nullptr).has_value());
  const Eigen::Matrix2d m =
      Vector2d(1 / lens.parameters()[0], 1 / lens.parameters()[1]).asDiagonal() * j.leftCols<2>();
  return m.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
}

// Decentring so strong that it folds the image before the radial terms do.
TEST(Perspective, TangentialTermsFoldTheImageOutsideTheDomain) {
  Random random(17);
  for (int i = 0; i < 300; ++i) {
    const double size = random.uniform(0.03, 0.3), turn = random.uniform(0, 2 * std::numbers::pi);
    const Perspective lens({600, 600, 640, 400, random.uniform(-0.2, 0.2), 0, size * std::cos(turn),
                            size * std::sin(turn)});
    const double border = std::min(2.0, lens.max_radius() * (1 - 1e-9));
    for (int k = 0; k < 64; ++k) {
      const double angle = 2 * std::numbers::pi * k / 64;
      EXPECT_GT(least_stretch(lens, border * Vector2d(std::cos(angle), std::sin(angle))), 0)
          << i << " " << angle;
    }
  }
  // Without radial terms it folds at 1 / (6 |p|), and the bound is not much below.
  for (const double p : {0.001, 0.02, 0.3}) {
    const Perspective lens({600, 600, 640, 400, 0, 0, p, 0});
    EXPECT_LT(lens.max_radius(), 1 / (6 * p));
    EXPECT_GT(lens.max_radius(), 0.9 / (6 * p));
  }
}

TEST(Fisheye, SeesBesideAndBehindTheCamera) {
  const Fisheye lens({300, 300, 640, 640});
  const auto beside = lens.project({1, 0, 0});
  ASSERT_TRUE(beside.has_value());
  EXPECT_NEAR(beside->x(), 640 + 300 * std::numbers::pi / 2, 1e-10);
  const auto behind = lens.project({1, 0, -1});
  ASSERT_TRUE(behind.has_value());
  EXPECT_NEAR(behind->x(), 640 + 300 * std::numbers::pi * 0.75, 1e-10);
  EXPECT_FALSE(lens.project({0, 0, -1}).has_value());
  EXPECT_EQ(*lens.project({0, 0, 1}), Vector2d(640, 640));
  // 1 + 3 k1 theta^2 = 0 at theta = 1.
  EXPECT_NEAR(Fisheye({300, 300, 0, 0, -1.0 / 3}).max_angle(), 1, 1e-15);
}

TEST(Fisheye, JacobianNearTheAxis) {
  const Fisheye lens({300, 310, 640, 640, 0.1, 0.02});
  for (const double r : {0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-5}) {
    PointJacobian j;
    Fisheye::ParameterJacobian by_parameters;
    ASSERT_TRUE(lens.project({r, r, 2}, &j, &by_parameters).has_value());
    EXPECT_NEAR(j(0, 0), 150, 1e-6);
    EXPECT_NEAR(j(1, 1), 155, 1e-6);
    EXPECT_NEAR(j(0, 1), 0, 1e-6);
    EXPECT_TRUE(by_parameters.allFinite());
  }
}

TEST(FieldOfView, InvertsAndKnowsAWorkedNumber) {
  EXPECT_NEAR(focal_from_field_of_view_px(std::numbers::pi / 2, 1280), 640, 1e-10);
  EXPECT_NEAR(field_of_view_rad(focal_from_field_of_view_px(0.7, 800), 800), 0.7, 1e-15);
}

// A pinhole of W x H pixels spans 2 atan(W / (2 f)) across if its centre is that of the image.
TEST(FieldOfView, ReachesToTheOuterEdgesOfThePixels) {
  const ImageSize size{640, 480};
  const auto seen = field_of_view({pinhole(500, 510, 319.5, 239.5), size});
  ASSERT_TRUE(seen.has_value());
  EXPECT_NEAR(seen->horizontal_rad, 2 * std::atan2(320, 500), 1e-12);
  EXPECT_NEAR(seen->vertical_rad, 2 * std::atan2(240, 510), 1e-12);
  EXPECT_NEAR(seen->diagonal_rad, 2 * std::atan(std::hypot(320.0 / 500, 240.0 / 510)), 1e-12);
  // An equidistant fisheye shows an angle for each pixel.
  const auto wide = field_of_view({Fisheye({150, 150, 310, 230}), size});
  EXPECT_NEAR(wide->horizontal_rad, 640.0 / 150, 1e-12);
  EXPECT_NEAR(wide->vertical_rad, 480.0 / 150, 1e-12);
  EXPECT_FALSE(field_of_view({Parallel({500, 500, 320, 240}), size}).has_value());
}

TEST(Camera, ImageSpansFromMinusHalf) {
  const ImageSize size{1280, 800};
  EXPECT_EQ(image_centre(size), Vector2d(639.5, 399.5));
  EXPECT_TRUE(contains(size, {-0.5, -0.5}));
  EXPECT_FALSE(contains(size, {1279.5, 0}));
  EXPECT_FALSE(contains(size, {std::nan(""), 0}));
}

TEST(Polynomial, FindsTheSmallestRootAmongClosePairs) {
  // (x - 1)(x - 1.001)(x - 3)
  const Polynomial p =
      multiply(multiply(Polynomial{-1, 1}, Polynomial{-1.001, 1}), Polynomial{-3, 1});
  EXPECT_NEAR(smallest_positive_root(p, 10), 1, 1e-10);
  EXPECT_EQ(smallest_positive_root(Polynomial{1, 0, 1}, 1e6), INFINITY);
  EXPECT_EQ(smallest_positive_root(Polynomial{1, 1}, 1e6), INFINITY);
  EXPECT_NEAR(smallest_positive_root(Polynomial{1, -1e-3}, 1e6), 1000, 1e-9);
}

}  // namespace
}  // namespace tagcal
