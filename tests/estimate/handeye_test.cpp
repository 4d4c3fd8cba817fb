#include "tagcal/estimate/handeye.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "handeye_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
namespace {

TEST(Handeye, FindsTheTruthWithoutNoise) {
  for (const CameraMount mount : {CameraMount::hand, CameraMount::base})
    for (const int num_poses : {3, 10}) {
      const HandeyeTask task = task_of({.mount = mount,
                                        .num_poses = num_poses,
                                        .robot_sigma_m = 0,
                                        .robot_sigma_rad = 0,
                                        .sigma_px = 0,
                                        .known_lens = true},
                                       1);
      const HandeyeEstimate answer = estimate(task);
      ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
      EXPECT_LT(minus(task.mount_from_camera, answer.mount_from_camera).norm(), 1e-6);
      EXPECT_LT(minus(task.holder_from_board, answer.holder_from_board).norm(), 1e-6);
    }
}

struct HandeyeCase {
  const char* name;
  HandeyeKind kind;
  Status status;
};

class HandeyeStatus : public testing::TestWithParam<HandeyeCase> {};

TEST_P(HandeyeStatus, IsSaid) {
  for (std::uint64_t seed = 20; seed < 24; ++seed) {
    const HandeyeEstimate answer = estimate(task_of(GetParam().kind, seed));
    EXPECT_EQ(answer.status, GetParam().status) << seed << all_sentences(answer);
    EXPECT_EQ(answer.reading.has_value(), answer.status == Status::wrong_direction ||
                                              GetParam().kind.mistake == RobotMistake::shifted);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, HandeyeStatus,
    testing::Values(
        HandeyeCase{"Parallel", {.axis_spread_rad = 0}, Status::rotation_axes_parallel},
        HandeyeCase{"NoRotation", {.turn_rad = 0}, Status::no_rotation},
        HandeyeCase{"Inverse", {.mistake = RobotMistake::inverse}, Status::wrong_direction},
        HandeyeCase{"Millimetres", {.mistake = RobotMistake::millimetres}, Status::wrong_direction},
        HandeyeCase{
            "Quaternions", {.mistake = RobotMistake::quaternion_order}, Status::wrong_direction},
        HandeyeCase{"Shifted", {.mistake = RobotMistake::shifted}, Status::not_synchronous}),
    [](const auto& tested) { return tested.param.name; });

TEST(Handeye, GivesTheRestIfTheAxesAreParallel) {
  const HandeyeTask task = task_of({.axis_spread_rad = 0}, 31);
  const HandeyeEstimate answer = estimate(task);
  ASSERT_EQ(answer.status, Status::rotation_axes_parallel);
  const Vector6d e = minus(task.mount_from_camera, answer.mount_from_camera);
  EXPECT_LT(e.head<3>().norm(), 0.01);
  EXPECT_LT(nees(task, answer), 4);
}

// Along parallel axes every place is as good as another one, and the cost falls without an end:
// bundles that are not held there do not converge in one world of twelve.
TEST(Handeye, ConvergesWhereNothingIsDetermined) {
  for (const int num_poses : {4, 15})
    for (std::uint64_t seed = 100; seed < 140; ++seed) {
      const HandeyeEstimate answer = estimate(
          task_of({.num_poses = num_poses, .axis_spread_rad = 0, .known_lens = true}, seed));
      EXPECT_EQ(answer.status, Status::rotation_axes_parallel) << all_sentences(answer);
      EXPECT_FALSE(has(answer, "not_converged")) << seed << all_sentences(answer);
    }
}

// Covariances of the corners of one view say nothing of the noise of the others.
TEST(Handeye, OneViewWithCovariancesChangesLittle) {
  HandeyeTask task = task_of({.num_poses = 12, .sigma_px = 0.1, .known_lens = true}, 9);
  const HandeyeEstimate none = estimate(task);
  ViewCorrespondences& seen = task.views[0].seen;
  seen.covariance_px2.assign(seen.correspondences.size(), 0.01 * Matrix2::Identity());
  const HandeyeEstimate one = estimate(task);
  EXPECT_NEAR(one.sigma_px, none.sigma_px, 0.01);
  EXPECT_NEAR(one.robot_sigma_m / none.robot_sigma_m, 1, 0.1);
  for (Eigen::Index i = 0; i < 6; ++i)
    EXPECT_NEAR(one.camera_covariance(i, i) / none.camera_covariance(i, i), 1, 0.2) << i;
}

// Inverse poses fit three views as well as right ones.
TEST(Handeye, WarnsOfViewsThatCannotShowAnotherReading) {
  int answered = 0;
  for (std::uint64_t seed = 150; seed < 220; ++seed) {
    const HandeyeEstimate answer = estimate(task_of({.num_poses = 3,
                                                     .axis_spread_rad = 0.3,
                                                     .robot_sigma_m = 0.3e-3,
                                                     .robot_sigma_rad = 1e-3,
                                                     .sigma_px = 0.1,
                                                     .mistake = RobotMistake::inverse},
                                                    seed));
    if (!is_answer(answer.status)) continue;
    ++answered;
    EXPECT_TRUE(has(answer, "few_views")) << seed << all_sentences(answer);
  }
  EXPECT_GT(answered, 10);
}

// Five poses about one axis, nearly: the closed form of the right reading is poor. A world of the
// study `handeye`.
TEST(Handeye, RefusesAReadingWhoseBundleIsLessLikely) {
  Random random(111, 11);
  for (int i = 0; i < 6; ++i) random.uniform();
  const HandeyeEstimate answer = estimate(draw_handeye({.mount = CameraMount::hand,
                                                        .num_poses = 5,
                                                        .axis_spread_rad = 0.032207372173935753,
                                                        .robot_sigma_m = 0.0002806664919894951,
                                                        .robot_sigma_rad = 0.0042351531666115641,
                                                        .sigma_px = 0.10662751768466849,
                                                        .mistake = RobotMistake::quaternion_order},
                                                       random));
  EXPECT_EQ(answer.status, Status::wrong_direction) << all_sentences(answer);
}

TEST(Handeye, RefusesFewerThanThreePoses) {
  HandeyeTask task = task_of({.num_poses = 5}, 5);
  for (HandeyeView& view : task.views) view.base_from_hand = task.views[0].base_from_hand;
  EXPECT_EQ(estimate(task).status, Status::degenerate);
  task = task_of({.num_poses = 2}, 5);
  EXPECT_EQ(estimate(task).status, Status::degenerate);
  EXPECT_EQ(calibrate_handeye({}, task.camera).status, Status::degenerate);
}

TEST(Handeye, AdvisesAPoseThatHelps) {
  const HandeyeEstimate answer = estimate(task_of({.num_poses = 6, .axis_spread_rad = 0.1}, 9));
  ASSERT_TRUE(answer.next) << all_sentences(answer);
  EXPECT_LT(answer.next->sigma_m, 0.9 * answer.next->sigma_now_m);
}

// A path of the robot over time, and pictures 40 ms late.
struct TimedTask {
  HandeyeTask task;
  RobotPath path;
};

TimedTask timed_task(double late_s) {
  TimedTask timed{task_of({.num_poses = 12, .robot_sigma_m = 0, .robot_sigma_rad = 0}, 40), {}};
  Random random(41);
  // From each pose to the next one in a second; the pictures are taken in the middle of a motion.
  std::vector<HandeyeView>& views = timed.task.views;
  RobotPath& path = timed.path;
  for (std::size_t i = 0; i < views.size(); ++i) {
    Vector6d speed;
    for (int k = 0; k < 6; ++k) speed[k] = 0.3 * random.normal();
    for (int step = -10; step <= 10; ++step) {
      path.times_s.push_back(10.0 * static_cast<double>(i) + 0.05 * step);
      path.base_from_hand.push_back(retract(views[i].base_from_hand, 0.05 * step * speed));
    }
    views[i].time_s = 10.0 * static_cast<double>(i) - late_s;
  }
  return timed;
}

TEST(Handeye, FindsTheOffsetOfTime) {
  const TimedTask timed = timed_task(0.04);
  HandeyeOptions options;
  options.path = timed.path;
  EXPECT_EQ(estimate(timed.task, options).status, Status::not_synchronous);
  options.find_time_offset = true;
  const HandeyeEstimate answer = estimate(timed.task, options);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  ASSERT_TRUE(answer.time_offset_s);
  EXPECT_NEAR(*answer.time_offset_s, 0.04, 5 * answer.sigma_time_offset_s + 1e-6);
  EXPECT_LT(answer.sigma_time_offset_s, 2e-3);
  EXPECT_LT(nees(timed.task, answer), 4);
}

TEST(Handeye, AcceptsClocksThatAgree) {
  const TimedTask timed = timed_task(0);
  HandeyeOptions options;
  options.path = timed.path;
  const HandeyeEstimate answer = estimate(timed.task, options);
  EXPECT_EQ(answer.status, Status::ok) << all_sentences(answer);
}

// The views of a task as poses of a camera, or of a rig of that one camera at its origin.
std::vector<HandeyeView> posed(const HandeyeTask& task, const KnownRig& rig) {
  std::vector<HandeyeView> views = task.views;
  for (HandeyeView& view : views) {
    view.poses = estimate_rig_pose(std::span(&view.seen, 1), rig).parts;
    view.seen = {};
  }
  return views;
}

KnownRig rig_of(const HandeyeTask& task) {
  KnownRig rig;
  rig.cameras.push_back({"cam0", task.camera, Pose(), {}});
  const Eigen::Index k = task.camera.covariance.cols();
  if (k == 0) return rig;
  rig.covariance = MatrixX::Zero(6 + k, 6 + k);
  rig.covariance.bottomRightCorner(k, k) = task.camera.covariance;
  return rig;
}

// The witness: the bundle in pixels, which has the covariance of the lens.
TEST(Handeye, FromPosesGivesTheAnswerOfTheirCorners) {
  for (const bool known_lens : {true, false})
    for (const CameraMount mount : {CameraMount::hand, CameraMount::base}) {
      const HandeyeTask task = task_of({.mount = mount, .known_lens = known_lens}, 60);
      const KnownRig rig = rig_of(task);
      HandeyeOptions options;
      options.mount = mount;
      const HandeyeEstimate by_corners = estimate(task);
      const HandeyeEstimate by_poses =
          calibrate_handeye_from_poses(posed(task, rig), rig.covariance, options);
      ASSERT_EQ(by_poses.status, Status::ok) << all_sentences(by_poses);
      EXPECT_EQ(has(by_poses, "lens_without_covariance"), known_lens);
      const Vector6d step = minus(by_poses.mount_from_camera, by_corners.mount_from_camera);
      const Vector6d sigma = by_corners.camera_covariance.diagonal().cwiseSqrt();
      EXPECT_LT(step.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.1);
      const Vector6d ratio = by_poses.camera_covariance.diagonal().cwiseSqrt().cwiseQuotient(sigma);
      EXPECT_NEAR(ratio.minCoeff(), 1, 0.03) << ratio.transpose();
      EXPECT_NEAR(ratio.maxCoeff(), 1, 0.03) << ratio.transpose();
      EXPECT_NEAR(by_poses.robot_sigma_m, by_corners.robot_sigma_m, 0.03e-3);
      ASSERT_TRUE(by_poses.next);
      EXPECT_LT(by_poses.next->sigma_m, by_poses.next->sigma_now_m);
    }
}

// Nobody knows by poses alone where the corners are; their covariances tell.
TEST(Handeye, FromPosesKnowsNoCorners) {
  const HandeyeTask task = task_of({}, 61);
  std::vector<HandeyeView> views = posed(task, rig_of(task));
  views[3].poses.clear();
  HandeyeOptions options;
  options.mount = task.mount;
  const HandeyeEstimate answer =
      calibrate_handeye_from_poses(views, rig_of(task).covariance, options);
  EXPECT_EQ(answer.unusable, std::vector<std::size_t>{3});
  EXPECT_EQ(answer.num_corners, 0);
  EXPECT_TRUE(std::isnan(answer.rms_px) && std::isnan(answer.sigma_px));
  EXPECT_NEAR(answer.board_spread_m, estimate(task).board_spread_m, 0.3e-3);
}

// Not the robot is to blame for views without a pose.
TEST(Handeye, SaysWhyNoViewHasAPose) {
  const HandeyeTask task = task_of({.num_poses = 4}, 62);
  std::vector<HandeyeView> views = posed(task, rig_of(task));
  for (HandeyeView& view : views) {
    view.poses.clear();
    add(view.findings, code::pair_contradicts, "left and right contradict one another");
  }
  const HandeyeEstimate answer = calibrate_handeye_from_poses(views, rig_of(task).covariance);
  EXPECT_EQ(answer.status, Status::degenerate);
  const auto why = std::ranges::find_if(answer.findings, is_refusal);
  ASSERT_NE(why, answer.findings.end());
  EXPECT_EQ(why->sentence,
            "4 of 4 views have no pose that can be used, mostly because left and right contradict "
            "one another");
}

TEST(Handeye, FromPosesRefusesBadInput) {
  const HandeyeTask task = task_of({.num_poses = 4}, 62);
  const std::vector<HandeyeView> good = posed(task, rig_of(task));
  EXPECT_THROW(calibrate_handeye_from_poses(good), Error);  // the responses have no covariance
  std::vector<HandeyeView> views = good;
  for (HandeyeView& view : views) view.poses[0].response = {};
  EXPECT_NO_THROW(calibrate_handeye_from_poses(views));
  views[1].poses[0].covariance.setZero();
  EXPECT_THROW(calibrate_handeye_from_poses(views), Error);
}

TEST(Handeye, RefusesBadInput) {
  HandeyeTask task = task_of({.num_poses = 4}, 5);
  HandeyeOptions options;
  options.find_time_offset = true;
  EXPECT_THROW(estimate(task, options), Error);
  task.camera.covariance = MatrixX::Zero(2, 2);
  EXPECT_THROW(estimate(task), Error);
  task = task_of({.num_poses = 4}, 5);
  task.views[2].base_from_hand = {Eigen::Quaterniond::Identity(),
                                  {0, std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_THROW(estimate(task), Error);
}

}  // namespace
}  // namespace tagcal
