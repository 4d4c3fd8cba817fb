#include "tagcal/estimate/pose/residual_test.hpp"

#include <gtest/gtest.h>

#include "tagcal/estimate/pose/ransac.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> grid_pixels() {
  std::vector<Vector2d> pixels;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) pixels.emplace_back(300 + 50 * x, 100 + 50 * y);
  return pixels;
}

TEST(ResidualTest, NoiseIsNotCorrelated) {
  Random random(1);
  const auto pixels = grid_pixels();
  for (int i = 0; i < 2000; ++i) {
    const std::size_t n = 12 + random.index(pixels.size() - 11);
    std::vector<Vector2d> residuals;
    for (std::size_t k = 0; k < n; ++k) residuals.emplace_back(random.normal(), random.normal());
    EXPECT_FALSE(spatially_correlated({pixels.data(), n}, residuals)) << n;
  }
}

// W C W' = 1, which the transpose of W does not give where the coordinates are correlated.
TEST(ResidualTest, WhiteningMakesTheCovarianceOne) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix2d root;
    root << random.normal(), random.normal(), random.normal(), random.normal();
    const Matrix2 covariance = root * root.transpose() + 0.01 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d w = whitening_of(covariance);
    EXPECT_LT((w * covariance * w.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-9);
  }
}

// Derivatives of whitened residuals by the lens, by difference quotients.
TEST(ResidualTest, WhitenedDerivativesAreThoseOfWhitenedResiduals) {
  Random random(5);
  const auto lens = std::get<Perspective>(opencv5_lens());
  const Pose pose(exp_rotation({0.3, -0.2, 0.1}), {-0.2, 0.1, 1.5});
  ViewProblem view;
  for (int i = 0; i < 10; ++i) {
    view.correspondences.push_back(
        {{random.uniform(0, 0.5), random.uniform(0, 0.5), 0}, {600, 400}});
    Matrix2 w;
    w << random.normal(), random.normal(), random.normal(), random.normal();
    view.whitening.push_back(w);
  }
  std::vector<FreeParameter> free;
  for (int k = 0; k < 9; ++k) free.push_back({Perspective::kParameters[k].name, {k}});
  const auto at = [&](int k, double h) {
    auto parameters = lens.parameters();
    parameters[k] += h;
    return Eigen::VectorXd(reprojection(view, Perspective(parameters), free, pose)->residuals);
  };
  const Reprojection here = reprojection(view, lens, free, pose).value();
  for (int k = 0; k < 9; ++k) {
    const Eigen::VectorXd difference = (at(k, 1e-6) - at(k, -1e-6)) / 2e-6;
    EXPECT_LT((here.by_parameters.col(k) - difference).norm(), 1e-6 * (1 + difference.norm()))
        << free[k].name;
  }
}

TEST(ResidualTest, ResidualsOfAWrongLensAreCorrelated) {
  Random random(2);
  const auto pixels = grid_pixels();
  std::vector<Vector2d> residuals;
  for (const Vector2d& p : pixels) {
    const Vector2d q = (p - Vector2d(575, 375)) / 300;
    residuals.push_back((q.squaredNorm() - 0.7) * q +
                        0.2 * Vector2d(random.normal(), random.normal()));
  }
  EXPECT_TRUE(spatially_correlated(pixels, residuals));
  EXPECT_FALSE(spatially_correlated({pixels.data(), 11}, {residuals.data(), 11}));
  // The rounding of exact pixels is no model error.
  for (Eigen::Vector2d& r : residuals) r *= 1e-11;
  EXPECT_FALSE(spatially_correlated(pixels, residuals));
}

TEST(ResidualTest, WithinAndComplement) {
  const std::vector<double> squares = {0, 24.9, 25.1, 1e9, 3};
  const std::vector<std::size_t> near = indices_within(squares, 25);
  EXPECT_EQ(near, (std::vector<std::size_t>{0, 1, 4}));
  EXPECT_EQ(complement(near, 5), (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(complement({}, 2), (std::vector<std::size_t>{0, 1}));
}

// A pinhole fitted to a distorted view would have a focal length that is wrong by many standard
// deviations.
TEST(ResidualTest, NoFocalLengthOfALensThatIsNoPinhole) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Pose pose =
        looking_at_board({0, 0, 0}, random.uniform(0.5, 0.9), random.uniform(0.8, 1.2), random);
    const Camera bent{Perspective({900, 900, 639.5, 399.5, -0.2, 0.06, 0, 0, 0}), {1280, 800}};
    const Camera straight{pinhole(900, 900, 639.5, 399.5), {1280, 800}};
    const auto of_bent = estimate_pose_and_focal(
        seen_by(bent.lens, board_points(), pose, 0.2, random), bent.image_size);
    EXPECT_FALSE(is_answer(of_bent.status)) << i;
    const auto of_straight = estimate_pose_and_focal(
        seen_by(straight.lens, board_points(), pose, 0.2, random), straight.image_size);
    EXPECT_EQ(of_straight.status, Status::ok) << i;
    EXPECT_NEAR(of_straight.focal_px, 900, 6 * of_straight.sigma_focal_px);
  }
}

}  // namespace
}  // namespace tagcal
