// Residuals that contradict the stated noise raise it once, for the minima, their odds, the
// covariance and the status.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace study;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

bool is_understated(const Finding& f) { return f.code == std::string_view("noise_understated"); }

template <typename Estimate>
bool is_raised(const Estimate& e) {
  return std::ranges::any_of(e.findings, is_understated);
}

// Three pictures of four points, from answers.opencv.org/questions/12547.
TEST(RaisedNoise, CountsInTheOddsOfTheOtherPose) {
  const Vector3d points[] = {{0, 0, 0}, {0.0995, 0, 0}, {0, 0.0995, 0}, {0.1485, 0.0995, 0}};
  const struct {
    Vector2d pixels[4];
    double sigma_px, odds;
  } views[] = {
      {{{251.249, 226.554}, {330.281, 231.851}, {246.126, 304.043}, {363.574, 310.183}},
       0.64,
       0.82},
      {{{251.338, 226.589}, {330.266, 231.837}, {245.968, 304.039}, {363.583, 310.189}},
       0.72,
       0.69},
      {{{251.271, 226.561}, {330.280, 231.822}, {246.076, 304.024}, {363.358, 310.176}},
       0.59,
       0.90},
  };
  const Camera camera{pinhole(800, 800, 320, 240), {640, 480}};
  for (const auto& view : views) {
    std::vector<Correspondence> corners;
    for (int i = 0; i < 4; ++i) corners.push_back({points[i], view.pixels[i]});
    const PoseEstimate e = estimate_pose(corners, camera, {.sigma_px = 0.15});
    EXPECT_EQ(e.status, Status::ambiguous);
    EXPECT_TRUE(is_raised(e));
    EXPECT_NEAR(e.sigma_px, view.sigma_px, 0.005);
    ASSERT_EQ(e.hypotheses.size(), 2u);
    EXPECT_NEAR(e.hypotheses[0].probability, view.odds, 0.01);
    EXPECT_NEAR(
        angle_between_rad(e.hypotheses[0].camera_from_target, e.hypotheses[1].camera_from_target),
        23 * kDegree, 2 * kDegree);
  }
}

// 4, 6, 20 or 144 points: a square, points in a plane, points in space, a board.
std::vector<Vector3d> some_points(int n, Random& random) {
  if (n == 144) return tag_grid_points(6);
  return n == 4 ? square_points(0.1) : points_in_box(n, 0.1, n == 6 ? 0 : 1, random);
}

template <typename Estimate>
void expect_equal(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.outliers, b.outliers);
  EXPECT_NEAR(a.sigma_px, b.sigma_px, 1e-9 * b.sigma_px);
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (std::size_t i = 0; i < a.hypotheses.size(); ++i) {
    const PoseHypothesis &p = a.hypotheses[i], &q = b.hypotheses[i];
    EXPECT_NEAR(p.probability, q.probability, 1e-6);
    EXPECT_LT(angle_between_rad(p.camera_from_target, q.camera_from_target), 1e-6);
    EXPECT_LT((p.covariance - q.covariance).norm(), 1e-6 * q.covariance.norm());
  }
}

// Views from 1 to 4 m whose noise is stated three times too small.
TEST(RaisedNoise, IsAsGoodAsIfItHadBeenStated) {
  for (const int n : {4, 6, 20}) {
    Random random(static_cast<std::uint64_t>(n));
    int raised = 0, ambiguous = 0;
    for (int i = 0; i < 300; ++i) {
      const PoseTask task = draw_task(some_points(n, random), {20, 60, 1, 4, 0.3}, random);
      const PoseEstimate e = estimate_pose(task.correspondences, task.camera, {.sigma_px = 0.1});
      if (!is_answer(e.status) || !is_raised(e)) continue;
      ++raised;
      ambiguous += e.status == Status::ambiguous;
      expect_equal(e, estimate_pose(task.correspondences, task.camera, {.sigma_px = e.sigma_px}));
    }
    EXPECT_GT(raised, 50) << n;
    if (n < 20) {
      EXPECT_GT(ambiguous, 20) << n;
    }
  }
}

TEST(RaisedNoise, CountsInTheFocalLength) {
  for (const int n : {4, 6, 20}) {
    Random random(static_cast<std::uint64_t>(n));
    int raised = 0;
    for (int i = 0; i < 200; ++i) {
      const PoseTask task = draw_task(some_points(n, random), {30, 60, 0.5, 1, 0.3}, random);
      const ImageSize size = task.camera.image_size;
      const auto e =
          estimate_pose_and_focal(task.correspondences, size, {{.sigma_px = 0.1}, 0, true});
      if (!is_answer(e.status) || !is_raised(e)) continue;
      ++raised;
      const auto stated =
          estimate_pose_and_focal(task.correspondences, size, {{.sigma_px = e.sigma_px}, 0, true});
      expect_equal(e, stated);
      EXPECT_NEAR(e.focal_px, stated.focal_px, 1e-3);
      EXPECT_NEAR(e.sigma_focal_px, stated.sigma_focal_px, 1e-3);
    }
    EXPECT_GT(raised, 10) << n;
  }
}

// The poses of a prior focal length have the noise that the only such finding states.
TEST(RaisedNoise, IsSaidOnceBesideAPrior) {
  Random random(4);
  int raised = 0;
  for (int i = 0; i < 50; ++i) {
    const PoseTask task = draw_task(square_points(0.1), {0, 30, 1, 2, 1.5}, random);
    const auto e = estimate_pose_and_focal(task.correspondences, task.camera.image_size,
                                           {{.sigma_px = 0.3}, kStudyFocalPx, true});
    const auto count = std::ranges::count_if(e.findings, is_understated);
    EXPECT_LE(count, 1);
    raised += count == 1 && e.status == Status::focal_not_observable && !e.hypotheses.empty();
  }
  EXPECT_GT(raised, 10);
}

// Covariances that are too small are scaled as a noise is.
TEST(RaisedNoise, ScalesCovariances) {
  Random random(3);
  const std::vector<Matrix2> covariances(4, 0.1 * 0.1 * Matrix2::Identity());
  int ambiguous = 0;
  for (int i = 0; i < 200; ++i) {
    const PoseTask task = draw_task(square_points(0.1), {20, 60, 1, 4, 0.3}, random);
    PoseEstimate a = estimate_pose(task.correspondences, task.camera, {.sigma_px = 0.1});
    const PoseEstimate b =
        estimate_pose(task.correspondences, task.camera, {.covariance_px2 = covariances});
    EXPECT_EQ(is_raised(a), is_raised(b));
    ambiguous += is_raised(a) && a.status == Status::ambiguous;
    a.sigma_px /= 0.1;
    expect_equal(a, b);
  }
  EXPECT_GT(ambiguous, 20);
}

// The residuals of right views contradict their noise at most once in 5,000.
TEST(RaisedNoise, IsNotTheNoiseOfRightViews) {
  for (const int n : {4, 6, 20, 144}) {
    Random random(100 + static_cast<std::uint64_t>(n));
    int raised = 0;
    for (int i = 0; i < 5000; ++i) {
      const PoseTask task = draw_task(some_points(n, random), {0, 60, 0.7, 3, 0.3}, random);
      raised += is_raised(estimate_pose(task.correspondences, task.camera, {.sigma_px = 0.3}));
    }
    EXPECT_LE(raised, 2) << n;
  }
}

// A corner that is 30 px off is rejected. The others are inliers of the noise that they raise, also
// those that the stated noise would reject.
TEST(RaisedNoise, IsThatOfAllInliers) {
  for (const double ratio : {1.0, 2.5}) {
    Random random(5);
    int answers = 0;
    for (int i = 0; i < 100; ++i) {
      const double sigma_px = 0.2 * ratio;
      PoseTask task = draw_task(tag_grid_points(3), {20, 50, 1, 2, sigma_px}, random);
      task.correspondences[7].pixel.x() += 30;
      const PoseEstimate e = estimate_pose(task.correspondences, task.camera, {.sigma_px = 0.2});
      if (!is_answer(e.status)) continue;
      ++answers;
      EXPECT_EQ(is_raised(e), ratio > 1) << i;
      EXPECT_EQ(e.outliers, std::vector<std::size_t>{7}) << i;
      EXPECT_NEAR(e.sigma_px, sigma_px, 0.3 * sigma_px) << i;
      expect_equal(e, estimate_pose(task.correspondences, task.camera, {.sigma_px = e.sigma_px}));
    }
    EXPECT_GE(answers, 98) << ratio;
  }
}

// A quarter of the corners is 2 to 4 px off. A noise that is twice the stated one hides at most one
// in a hundred.
TEST(RaisedNoise, HidesNoOutliers) {
  Random random(6);
  std::size_t hidden = 0, wrong = 0;
  for (int i = 0; i < 100; ++i) {
    PoseTask task = draw_task(tag_grid_points(3), {20, 50, 1, 2, 0.3}, random);
    for (std::size_t k = 0; k < task.correspondences.size(); k += 4)
      task.correspondences[k].pixel +=
          random.uniform(2, 4) * Vector2d(k % 8 == 0 ? 1 : -1, random.uniform(-1, 1));
    const PoseEstimate e = estimate_pose(task.correspondences, task.camera, {.sigma_px = 0.15});
    if (!is_answer(e.status)) continue;
    for (std::size_t k = 0; k < task.correspondences.size(); k += 4) {
      ++wrong;
      hidden += !std::ranges::binary_search(e.outliers, k);
    }
  }
  EXPECT_GT(wrong, 500u);
  EXPECT_LE(100 * hidden, wrong);
}

}  // namespace
}  // namespace tagcal
