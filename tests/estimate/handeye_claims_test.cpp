#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "handeye_worlds.hpp"
#include "tagcal/estimate/handeye.hpp"

namespace tagcal {
namespace {

// The robot's lengths tell the board's, within the prior of its print and beyond it.
TEST(HandeyeClaims, FindsTheScaleOfTheBoard) {
  for (const double board_scale : {0.9985, 1.02}) {
    const HandeyeTask task = task_of({.robot_sigma_m = 0,
                                      .robot_sigma_rad = 0,
                                      .sigma_px = 0,
                                      .board_scale = board_scale,
                                      .known_lens = true},
                                     1);
    const HandeyeEstimate answer = estimate(task);
    ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
    EXPECT_EQ(has(answer, "board_scale"), board_scale > 1.01) << all_sentences(answer);
    EXPECT_NEAR(answer.board_scale, board_scale, 1e-6);
    EXPECT_LT(minus(task.mount_from_camera, answer.mount_from_camera).norm(), 1e-6);
    EXPECT_LT(minus(task.holder_from_board, answer.holder_from_board).norm(), 1e-6);
  }
}

struct Claims {
  double nees = 0, scale_nees = 0, sigma_m = 0, sigma_rad = 0;  // means
  int num_board_scale = 0, num_rejected = 0;                    // findings, and views
};

// The board's scale is drawn about a mean, with the spread of prints on paper.
Claims claims_of(HandeyeKind kind, int num_worlds, std::uint64_t first) {
  Claims claims;
  const double mean_scale = kind.board_scale;
  for (int i = 0; i < num_worlds; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    Random random(seed, 4);
    kind.board_scale = mean_scale * (1 + 0.00141 * random.normal());
    kind.mount = i % 2 == 0 ? CameraMount::hand : CameraMount::base;
    const HandeyeTask task = task_of(kind, seed);
    const HandeyeEstimate answer = estimate(task);
    EXPECT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    claims.nees += nees(task, answer) / num_worlds;
    claims.scale_nees +=
        std::pow((answer.board_scale - kind.board_scale) / answer.sigma_board_scale, 2) /
        num_worlds;
    claims.sigma_m += answer.robot_sigma_m / num_worlds;
    claims.sigma_rad += answer.robot_sigma_rad / num_worlds;
    claims.num_board_scale += has(answer, "board_scale");
    claims.num_rejected += static_cast<int>(answer.rejected.size());
  }
  return claims;
}

void expect_true(const Claims& claims) {
  EXPECT_GT(claims.nees, 0.5);
  EXPECT_LT(claims.nees, 1.3);
  EXPECT_GT(claims.scale_nees, 0.5);
  EXPECT_LT(claims.scale_nees, 1.6);
  EXPECT_NEAR(claims.sigma_m, 1e-3, 0.15e-3);
  EXPECT_NEAR(claims.sigma_rad, 2e-3, 0.3e-3);
}

TEST(HandeyeClaims, ClaimsWhatItIsOffBy) {
  const Claims claims = claims_of({}, 40, 100);
  expect_true(claims);
  EXPECT_EQ(claims.num_board_scale, 0);
  EXPECT_LE(claims.num_rejected, 1);
}

TEST(HandeyeClaims, ClaimsWhatItIsOffByWithAWrongSizeOfTheBoard) {
  const Claims claims = claims_of({.num_poses = 20, .board_scale = 1.015}, 40, 400);
  expect_true(claims);
  EXPECT_GE(claims.num_board_scale, 38);
}

// The witness: the best of OpenCV's methods, on the same poses.
TEST(HandeyeClaims, IsNoWorseThanOpenCv) {
  const auto methods = study::handeye_methods();
  std::vector<double> squares(methods.size());
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const HandeyeTask task = task_of({}, 300 + seed);
    for (std::size_t i = 0; i < methods.size(); ++i) {
      const auto prepared = methods[i].prepare(task);
      prepared.solve();
      const auto answer = prepared.answer();
      ASSERT_TRUE(answer.mount_from_camera) << methods[i].name;
      squares[i] +=
          minus(task.mount_from_camera, *answer.mount_from_camera).tail<3>().squaredNorm();
    }
  }
  EXPECT_LT(squares[0], *std::min_element(squares.begin() + 1, squares.end()));
  // They solve the same problem: the worst peer is of the same size.
  EXPECT_LT(*std::min_element(squares.begin() + 1, squares.end()), 16 * squares[0]);
}

// Two or three that are off do not mask one another.
TEST(HandeyeClaims, RejectsWrongRobotPoses) {
  double sum = 0;
  constexpr int kWorlds = 30;
  for (int i = 0; i < kWorlds; ++i) {
    const HandeyeKind kind{.num_poses = 12, .num_wrong = 1 + i % 3};
    const HandeyeTask task = task_of(kind, 500 + static_cast<std::uint64_t>(i));
    const HandeyeEstimate answer = estimate(task);
    ASSERT_EQ(answer.status, Status::ok) << i << all_sentences(answer);
    EXPECT_TRUE(has(answer, "view_rejected"));
    for (int wrong = 0; wrong < kind.num_wrong; ++wrong)
      EXPECT_TRUE(std::ranges::count(answer.rejected, static_cast<std::size_t>(wrong))) << i;
    EXPECT_LE(std::ssize(answer.rejected), kind.num_wrong + 1) << i;
    sum += nees(task, answer) / kWorlds;
  }
  EXPECT_LT(sum, 1.6);
}

TEST(HandeyeClaims, KeepsRightRobotPoses) {
  int num_rejected = 0, num_views = 0;
  for (std::uint64_t seed = 600; seed < 660; ++seed) {
    const HandeyeTask task = task_of({.num_poses = 8 + static_cast<int>(seed % 23)}, seed);
    num_rejected += static_cast<int>(estimate(task).rejected.size());
    num_views += static_cast<int>(task.views.size());
  }
  EXPECT_LT(num_rejected, num_views / 300) << num_views;
}

}  // namespace
}  // namespace tagcal
