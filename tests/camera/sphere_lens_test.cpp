#include "tagcal/camera/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "expect.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d direction(double theta, double azimuth) {
  return {std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth),
          std::cos(theta)};
}

// Camera 0 of TUM-VI at 512 x 512 in the three models, of about the size that Basalt's paper gives.
const DoubleSphere kSphere({158.28, 158.27, 254.95, 256.90, -0.17, 0.59});

std::vector<Lens> lenses() {
  std::vector<Lens> all = {kSphere, ExtendedUnified({200, 210, 320, 240, 0.6, 1}),
                           ExtendedUnified({200, 190, 320, 240, 0.6, 1.1})};
  for (const double alpha : {0.0, 0.2, 0.5, 0.7, 1.0}) {
    for (const double xi : {-0.6, -0.2, 0.0, 0.3, 0.8})
      all.push_back(DoubleSphere({300, 310, 320, 240, xi, alpha}));
    for (const double beta : {0.5, 1.0, 2.0})
      all.push_back(ExtendedUnified({300, 310, 320, 240, alpha, beta}));
    all.push_back(ExtendedUnified({300, 310, 320, 240, alpha, 1}));
  }
  return all;
}

// The smallest angle from the axis outside the domain, which is a cone.
double domain_angle(const Lens& lens) {
  double low = 0, high = std::numbers::pi;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (in_domain(lens, direction(middle, 0.7)) ? low : high) = middle;
  }
  return high;
}

TEST(SphereLens, RayInvertsProjectOverTheWholeDomain) {
  Random random(1);
  for (const Lens& lens : lenses()) {
    const double limit = domain_angle(lens);
    for (int i = 0; i < 300; ++i) {
      const Vector3d x = direction(random.uniform(0, 0.999 * limit), random.uniform(0, 6.28));
      const auto pixel = project(lens, random.uniform(0.01, 100) * x);
      ASSERT_TRUE(pixel) << kind_of(lens).name;
      if (pixel->norm() > 5e3) continue;  // beside the pole
      const auto ray = ray_in_camera(lens, *pixel);
      ASSERT_TRUE(ray) << kind_of(lens).name << " " << pixel->transpose();
      EXPECT_NEAR(ray->direction.norm(), 1, 1e-14);
      EXPECT_LT((*project(lens, ray->direction) - *pixel).norm(), 1e-8) << kind_of(lens).name;
      EXPECT_LT((ray->direction - x).norm(), 1e-7) << kind_of(lens).name;
    }
  }
}

// The radius in the image grows with the angle up to the border of the domain, and there it has
// its largest value or no bound.
TEST(SphereLens, DomainIsWhereTheModelIsOneToOne) {
  for (const Lens& lens : lenses()) {
    const double limit = domain_angle(lens);
    ASSERT_GT(limit, 0.5) << kind_of(lens).name;
    double last = -1;
    for (int i = 0; i < 2000; ++i) {
      const auto pixel = project(lens, direction(limit * i / 2000, 0.7));
      ASSERT_TRUE(pixel);
      const double radius = (*pixel - Vector2d(parameters(lens)[2], parameters(lens)[3])).norm();
      EXPECT_GT(radius, last) << kind_of(lens).name << " " << i;
      last = radius;
    }
    EXPECT_FALSE(project(lens, direction(std::min(limit + 1e-6, std::numbers::pi), 0.7)));
    EXPECT_FALSE(in_domain(lens, Vector3d::Zero()));
    EXPECT_FALSE(project(lens, Vector3d(0, 0, -1)));
    EXPECT_FALSE(project(lens, Vector3d(0, NAN, 1)));
    EXPECT_FALSE(project(lens, Vector3d(0, INFINITY, 1)));
    EXPECT_FALSE(ray_in_camera(lens, Vector2d(NAN, 0)));
  }
}

// The formula of the paper, and its bound of the domain, which is not where the image turns back.
TEST(SphereLens, DoubleSphereIsThatOfThePaper) {
  const Vector3d x(0.3, -0.5, 0.7);
  const double d1 = x.norm(), z = -0.17 * d1 + 0.7, d2 = std::hypot(0.3, -0.5, z);
  const double denominator = 0.59 * d2 + 0.41 * z;
  const auto pixel = kSphere.project(x).value();
  EXPECT_NEAR(pixel.x(), 158.28 * 0.3 / denominator + 254.95, 1e-10);
  EXPECT_NEAR(pixel.y(), 158.27 * -0.5 / denominator + 256.90, 1e-10);

  const auto angle_of_paper = [](double xi, double w1) {
    return std::acos(-(w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1));
  };
  EXPECT_LT(angle_of_paper(-0.17, 0.41 / 0.59), domain_angle(kSphere) - 1e-3);
  EXPECT_GT(angle_of_paper(-0.17, 0), domain_angle(DoubleSphere({1, 1, 0, 0, -0.17, 1})) + 1e-3);
}

TEST(SphereLens, NestedModelsAgree) {
  const ExtendedUnified extended({200, 210, 320, 240, 0.6, 1});
  const DoubleSphere sphere({200, 210, 320, 240, 0, 0.6});
  const ExtendedUnified straight({200, 210, 320, 240, 0, 1});
  const Perspective plain = pinhole(200, 210, 320, 240);
  const ExtendedUnified omni = unified_from_omni(1.5, 500, 525, 320, 240);
  for (int i = 0; i < 100; ++i) {
    const Vector3d x = direction(0.014 * i, 0.1 * i);
    const double depth = 0.6 * x.norm() + 0.4 * x.z();
    const Vector2d unified(200 * x.x() / depth + 320, 210 * x.y() / depth + 240);
    EXPECT_LT((unified - *extended.project(x)).norm(), 1e-10);
    EXPECT_LT((unified - *sphere.project(x)).norm(), 1e-10);
    EXPECT_LT((*straight.project(x) - *plain.project(x)).norm(), 1e-9);
    const Vector2d mei(500 * x.x() / (x.z() + 1.5) + 320, 525 * x.y() / (x.z() + 1.5) + 240);
    EXPECT_LT((*omni.project(x) - mei).norm(), 1e-10);
  }
}

TEST(SphereLens, RefusesWhatIsNoLens) {
  const auto sphere = [](const DoubleSphere::Parameters& p) {
    return error_of([&] { static_cast<void>(DoubleSphere(p)); });
  };
  const auto unified = [](const ExtendedUnified::Parameters& p) {
    return error_of([&] { static_cast<void>(ExtendedUnified(p)); });
  };
  EXPECT_HAS(sphere({0, 1, 0, 0, 0, 0.5}), "fx must be > 0");
  EXPECT_HAS(sphere({1, 1, std::nan(""), 0, 0, 0.5}), "cx is not finite");
  EXPECT_HAS(sphere({1, 1, 0, 0, -1, 0.5}), "xi must be");
  EXPECT_HAS(sphere({1, 1, 0, 0, 0, 1.2}), "alpha must be");
  EXPECT_HAS(unified({1, 1, 0, 0, 0.5, 0}), "beta must be");
  EXPECT_HAS(unified({1, 1, 0, 0, -0.1, 1}), "alpha must be");
  EXPECT_HAS(error_of([] { unified_from_omni(-0.1, 1, 1, 0, 0); }), "xi must be");
}

}  // namespace
}  // namespace tagcal
