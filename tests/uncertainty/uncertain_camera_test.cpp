#include "tagcal/uncertainty/uncertain_camera.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "lenses.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr ImageSize kCameraSize = {1280, 800};

// A covariance with correlations and these standard deviations.
MatrixX covariance_of(const VectorXd& sigmas, Random& random) {
  Eigen::MatrixXd mixed(sigmas.size(), sigmas.size());
  for (Eigen::Index i = 0; i < mixed.size(); ++i) mixed.data()[i] = random.uniform(-1, 1);
  mixed += 2 * Eigen::MatrixXd::Identity(sigmas.size(), sigmas.size());
  const VectorXd lengths = mixed.rowwise().norm();
  mixed = (sigmas.cwiseQuotient(lengths)).asDiagonal() * mixed;
  return mixed * mixed.transpose();
}

VectorXd drawn(const Eigen::MatrixXd& covariance, Random& random) {
  VectorXd z(covariance.rows());
  for (double& value : z) value = random.normal();
  return covariance.llt().matrixL() * z;
}

UncertainCamera brown(Random& random) {
  const Lens lens = Perspective({900, 905, 640, 395, -0.2, 0.05, 1e-3, -1e-3, 0.01, 0, 0, 0});
  VectorXd sigmas(9);
  sigmas << 0.8, 0.7, 0.5, 0.6, 2e-3, 4e-3, 1e-4, 1e-4, 3e-3;
  return {&Model::named("opencv5"), {lens, kCameraSize}, covariance_of(sigmas, random)};
}

UncertainCamera fisheye(Random& random) {
  const Lens lens = Fisheye({400, 402, 640, 395, 0.02, -0.01, 0.003, -0.0005});
  VectorXd sigmas(8);
  sigmas << 0.5, 0.4, 0.5, 0.6, 1e-3, 1e-3, 5e-4, 1e-4;
  return {&Model::named("fisheye4"), {lens, kCameraSize}, covariance_of(sigmas, random)};
}

// The lens with parameters drawn from its covariance.
UncertainCamera sample(const UncertainCamera& lens, Random& random) {
  std::vector<double> free = lens.model->free_values(lens.camera.lens);
  const VectorXd step = drawn(lens.covariance, random);
  for (std::size_t i = 0; i < free.size(); ++i) free[i] += step[static_cast<Eigen::Index>(i)];
  return {nullptr, {*lens.model->lens(free, kCameraSize), kCameraSize}, {}};
}

// Mean outer product of samples about a value, beside its prediction: every variance along an
// eigenvector of the prediction within 10 % (4000 samples: standard error 2.2 %).
template <typename Samples>
void expect_covariance(const Samples& deviations, const Eigen::MatrixXd& predicted) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(predicted);
  for (Eigen::Index i = 0; i < predicted.rows(); ++i) {
    const double expected = axes.eigenvalues()[i];
    if (expected < 1e-9 * axes.eigenvalues().maxCoeff()) continue;  // a direction has length 1
    double sum = 0;
    for (const auto& d : deviations) sum += std::pow(axes.eigenvectors().col(i).dot(d), 2);
    EXPECT_NEAR(sum / static_cast<double>(deviations.size()) / expected, 1, 0.1) << i;
  }
}

constexpr int kSamples = 4000;

template <typename Draw>
auto many(const Draw& draw) {
  std::vector<decltype(draw())> values;
  for (int i = 0; i < kSamples; ++i) values.push_back(draw());
  return values;
}

class UncertainPoints : public testing::TestWithParam<bool> {
 protected:
  Random random_{5, 1};
  const UncertainCamera lens_ = GetParam() ? fisheye(random_) : brown(random_);
  const Matrix2 pixel_px2_ = (Matrix2() << 0.3, 0.1, 0.1, 0.2).finished();

  UncertainPixel pixel_near(const Vector2d& pixel) {
    return {pixel + Vector2d(drawn(Eigen::Matrix2d(pixel_px2_), random_)), Matrix2::Zero()};
  }
};

TEST_P(UncertainPoints, ProjectionsScatterAsTheirCovarianceSays) {
  const Matrix3d cov = covariance_of(Vector3d(2e-3, 1e-3, 5e-3), random_);
  const UncertainPoint point{{0.5, -0.3, 1.2}, cov};
  const UncertainPixel at = *project(lens_, point);
  EXPECT_LT((at.pixel - *project(lens_.camera.lens, point.x)).norm(), 1e-9);
  expect_covariance(
      many([&] {
        const UncertainPoint moved{point.x + Vector3d(drawn(cov, random_)), Matrix3d::Zero()};
        return Vector2d(project(sample(lens_, random_), moved)->pixel - at.pixel);
      }),
      at.covariance_px2);
}

TEST_P(UncertainPoints, DirectionsScatterAsTheirCovarianceSays) {
  const UncertainPixel pixel{{1000, 200}, pixel_px2_};
  const UncertainPoint ray = *direction(lens_, pixel);
  EXPECT_NEAR(ray.x.norm(), 1, 1e-14);
  EXPECT_LT((ray.covariance * ray.x).norm(), 1e-12);
  expect_covariance(
      many([&] {
        return Vector3d(direction(sample(lens_, random_), pixel_near(pixel.pixel))->x - ray.x);
      }),
      ray.covariance);
}

TEST_P(UncertainPoints, PointsAtADepthScatterAsTheirCovarianceSays) {
  const UncertainPixel pixel{{1000, 200}, pixel_px2_};
  const UncertainPoint point = *point_at_depth(lens_, pixel, 2, 0.01);
  EXPECT_NEAR(point.x.z(), 2, 1e-14);
  expect_covariance(
      many([&] {
        const double depth = 2 + 0.01 * random_.normal();
        return Vector3d(point_at_depth(sample(lens_, random_), pixel_near(pixel.pixel), depth)->x -
                        point.x);
      }),
      point.covariance);
}

TEST_P(UncertainPoints, PointsOnAPlaneScatterAsTheirCovarianceSays) {
  const Pose pose = translation({0.1, 0.2, 2}) * rotation_about_x(std::numbers::pi - 0.5);
  const UncertainPixel pixel{{900, 300}, pixel_px2_};
  const UncertainPoint point = *point_on_plane(lens_, pixel, pose);
  EXPECT_EQ(point.x.z(), 0);
  EXPECT_LT((*project(lens_.camera.lens, pose * point.x) - pixel.pixel).norm(), 1e-9);
  expect_covariance(
      many([&] {
        return Vector3d(point_on_plane(sample(lens_, random_), pixel_near(pixel.pixel), pose)->x -
                        point.x);
      }),
      point.covariance);
}

TEST_P(UncertainPoints, ThereAndBackIsThePixel) {
  for (double u = 0; u < kCameraSize.width; u += 61) {
    for (double v = 0; v < kCameraSize.height; v += 53) {
      const auto ray = direction(lens_, {{u, v}, Matrix2::Zero()});
      ASSERT_TRUE(ray);
      EXPECT_LT((project(lens_, *ray)->pixel - Vector2d(u, v)).norm(), 1e-9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, UncertainPoints, testing::Bool());

TEST(UncertainPointsDomain, NoValueOutsideIt) {
  const UncertainCamera lens{nullptr, {pinhole(500, 500, 320, 240)}, {}};
  EXPECT_FALSE(project(lens, {{0, 0, -1}, Matrix3d::Zero()}));
  EXPECT_FALSE(project(lens, {{0, 0, 0}, Matrix3d::Zero()}));
  const Pose behind = translation({0, 0, -2});
  EXPECT_FALSE(point_on_plane(lens, {{320, 240}, {}}, behind));
  EXPECT_FALSE(point_at_depth(lens, {{320, 240}, {}}, 0));
  const UncertainCamera wide{nullptr, {Fisheye({100, 100, 320, 240, 0, 0, 0, 0})}, {}};
  EXPECT_FALSE(point_at_depth(wide, {{640, 240}, {}}, 1));  // beside the camera
  EXPECT_FALSE(direction(wide, {{900, 240}, {}}));          // beyond half a turn
  const UncertainCamera parallel{nullptr, {Parallel({100, 100, 320, 240, 0, 0})}, {}};
  EXPECT_THROW(direction(parallel, {{320, 240}, {}}), Error);
  const UncertainCamera wrong{
      &Model::named("f"), {pinhole(500, 500, 320, 240)}, MatrixX::Identity(2, 2)};
  EXPECT_THROW(project(wrong, {{0, 0, 1}, Matrix3d::Zero()}), Error);
}

}  // namespace
}  // namespace tagcal
