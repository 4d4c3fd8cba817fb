#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "pose_bad_input_fixture.hpp"

// For any options and pixels the answer is right, or the status says why there is none.

namespace tagcal {
namespace {

TEST(PoseBadOptions, NoiseThatIsNone) {
  Random random(10);
  for (int i = 0; i < kTrials / 8; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    const double sigma =
        std::array{-1.0, kNan, -kInfinity, kInfinity, 1e300, 1e-300}[random.index(6)];
    EXPECT_EQ(with_camera(w, {.sigma_px = sigma}).status, Status::degenerate) << sigma;
    EXPECT_EQ(with_focal(w, {{.sigma_px = sigma}, 0}).status, Status::degenerate) << sigma;
  }
}

TEST(PoseBadOptions, NoiseOutOfAllProportion) {
  Random random(11);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.observe(i % 2 == 0 ? 0.3 : 0, random);
    const double sigma = std::array{1e100, 1e10, 1e4, 1e-4, 1e-10, 1e-100}[random.index(6)];
    const PoseOptions options{.sigma_px = sigma, .reject_outliers = i % 10 == 0};
    expect_sound(with_camera(w, options), w);
    expect_sound(with_focal(w, {options, 0}), w);
  }
}

TEST(PoseBadOptions, PriorFocalLengthsThatAreNone) {
  Random random(18);
  World w = draw_world(random);
  w.points = tag_points(0.1);
  w.truth = looking_at_board(Vector3d::Zero(), 0, 1, random);
  w.observe(0.3, random);
  for (const double prior : {kNan, kInfinity, -kInfinity, -900.0}) {
    const Answer answer = with_focal(w, {{}, prior});
    EXPECT_EQ(answer.status, Status::degenerate) << prior;
    EXPECT_TRUE(answer.hypotheses.empty());
  }
  for (const double prior : {1e-300, 1e-9, 1e9, 1e300}) expect_sound(with_focal(w, {{}, prior}), w);
}

TEST(PoseBadOptions, CovariancesThatAreNone) {
  Random random(12);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    std::vector<Matrix2> covariances(w.seen.size(), 0.09 * Matrix2::Identity());
    Matrix2& bad = covariances[random.index(covariances.size())];
    switch (random.index(6)) {
      case 0:
        bad.setZero();
        break;
      case 1:
        bad(random.index(2) == 0 ? 0 : 3) = kNan;
        break;
      case 2:
        bad *= -1;
        break;
      case 3:
        bad << 0.09, 0.2, 0.2, 0.09;
        break;
      case 4:
        bad *= kInfinity;
        break;
      case 5:
        bad << 0.09, 0.09, 0.09, 0.09;
        break;
    }
    const PoseOptions options{.reject_outliers = i % 10 == 0, .covariance_px2 = covariances};
    for (const Answer& answer : {with_camera(w, options), with_focal(w, {options, 0})}) {
      expect_sound(answer, w);
      EXPECT_EQ(answer.status, Status::degenerate) << bad;
    }
  }
}

TEST(PoseBadOptions, SpansOfAnotherSize) {
  Random random(13);
  for (int i = 0; i < 200; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    // Outliers start RANSAC, which uses the groups.
    w.seen[0].pixel += Vector2d(100, 50);
    const std::size_t n = random.index(2 * w.seen.size()) + 1;
    if (n == w.seen.size()) continue;
    const std::vector<Matrix2> covariances(n, 0.09 * Matrix2::Identity());
    const std::vector<int> groups(n, 1);
    for (const PoseOptions& options :
         {PoseOptions{.covariance_px2 = covariances}, PoseOptions{.groups = groups}}) {
      EXPECT_EQ(with_camera(w, options).status, Status::degenerate);
      EXPECT_EQ(with_focal(w, {options, 0}).status, Status::degenerate);
    }
  }
}

TEST(PoseBadOptions, AnImageWithoutSize) {
  Random random(14);
  World w = draw_world(random);
  w.observe(0, random);
  for (const ImageSize& size : {ImageSize{0, 0}, ImageSize{0, 800}, ImageSize{-5, 800}}) {
    const auto e = estimate_pose_and_focal(w.seen, size);
    EXPECT_EQ(e.status, Status::degenerate);
    EXPECT_FALSE(e.findings.empty());
  }
}

// Pixels beyond the fold of a lens have no ray.
TEST(PoseBadOptions, PixelsWithoutARay) {
  Random random(15);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.lens = i % 2 == 0 ? Lens(Perspective({900, 900, 640, 400, -0.3, 0, 0, 0, 0}))
                        : Lens(Fisheye({300, 300, 640, 400, -0.05, 0, 0, 0}));
    w.observe(0, random);
    const bool few = i % 4 < 2;
    const std::size_t bad = few ? 1 : w.seen.size();
    for (std::size_t k = 0; k < bad; ++k) w.seen[k].pixel = {random.uniform(3000, 1e6), 5000};
    const Answer answer = with_camera(w, {.reject_outliers = i % 10 < 4});
    expect_sound(answer, w);
    if (is_answer(answer.status)) {
      EXPECT_EQ(answer.outliers, std::vector<std::size_t>{0});
      EXPECT_LT(least_error(answer, w), 1e-6) << i;
    }
  }
}

}  // namespace
}  // namespace tagcal
