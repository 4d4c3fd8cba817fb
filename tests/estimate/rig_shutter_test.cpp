#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rig_worlds.hpp"
#include "rolling_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"

namespace tagcal {
namespace {

constexpr double kReadout = 0.02;

RigOptions finding_readouts() {
  RigOptions options;
  options.calibrate.front().model = "opencv5";
  options.find_readouts = true;
  return options;
}

// The error of a camera's focal length in standard deviations.
double focal_error_sd(const RigCameraEstimate& camera) {
  const Lens truth = opencv5_lens();
  return (parameters(camera.camera.camera.lens)[0] - parameters(truth)[0]) /
         lens_sigmas(camera.camera)[0];
}

void expect_readouts(const RigCalibration& answer) {
  for (const RigCameraEstimate& camera : answer.cameras) {
    ASSERT_TRUE(camera.own.readout) << camera.name;
    EXPECT_TRUE(camera.own.readout->is_seen) << camera.name;
    EXPECT_NEAR(camera.own.readout->seconds, kReadout, 4 * camera.own.readout->sigma_s);
  }
}

// The cameras run around the board: all pictures are displaced alike, which looks like other lenses
// and another place of the second camera.
TEST(RigShutter, StampsShowAMotionThatAllPicturesShare) {
  const RigDataset exact = rig_film(rising_ring(1), kReadout, 60);
  const RigDataset seen = with_noise(exact, 0.2, 1);
  RigOptions options = finding_readouts();
  const RigCalibration timed = calibrate_rig(seen, options);
  ASSERT_EQ(timed.status, Status::ok);
  expect_readouts(timed);
  for (const RigCameraEstimate& camera : timed.cameras)
    EXPECT_LT(std::abs(focal_error_sd(camera)), 4);
  EXPECT_LT(nees_of_extrinsics(exact, timed), 3);
  options.find_readouts = false;
  const RigCalibration alike = calibrate_rig(seen, options);
  ASSERT_EQ(alike.status, Status::ok);
  for (const RigCameraEstimate& camera : alike.cameras)
    EXPECT_GT(std::abs(focal_error_sd(camera)), 5);
}

// Squared errors over their claimed variances, of the places and of the focal lengths: chi-square
// of 60 and 20 degrees of freedom over their number is below 1.66 and 2.3 in 99.9 %. Without the
// readouts' part of the claims the places' is about 4.
TEST(RigShutter, TheClaimsCoverTheReadouts) {
  constexpr int kCount = 10;
  double places = 0, focal = 0;
  for (std::uint64_t seed = 1; seed <= kCount; ++seed) {
    const RigDataset exact = rig_film(rising_ring(seed), kReadout, 40);
    const RigCalibration answer = calibrate_rig(with_noise(exact, 0.2, seed), finding_readouts());
    ASSERT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    places += nees_of_extrinsics(exact, answer);
    for (const RigCameraEstimate& camera : answer.cameras)
      focal += std::pow(focal_error_sd(camera), 2) / 2;
  }
  EXPECT_LT(places / kCount, 1.66);
  EXPECT_LT(focal / kCount, 2.3);
}

TEST(RigShutter, AGlobalShutterChangesNothing) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const RigDataset seen = with_noise(rig_film(hand_motion(seed), 0, 40), 0.2, seed);
    RigOptions options = finding_readouts();
    const RigCalibration timed = calibrate_rig(seen, options);
    options.find_readouts = false;
    const RigCalibration plain = calibrate_rig(seen, options);
    EXPECT_EQ(timed.covariance, plain.covariance) << seed;
    EXPECT_EQ(timed.findings.size(), plain.findings.size()) << seed;
    for (std::size_t c = 0; c < plain.cameras.size(); ++c) {
      ASSERT_TRUE(timed.cameras[c].own.readout);
      EXPECT_FALSE(timed.cameras[c].own.readout->is_seen) << seed;
      EXPECT_EQ(minus(timed.cameras[c].camera_from_rig, plain.cameras[c].camera_from_rig).norm(),
                0);
    }
  }
}

// Lenses that are given: the places are off without the readout.
TEST(RigShutter, KnownLenses) {
  const RigDataset exact = rig_film(rising_ring(1), kReadout, 60);
  RigOptions options = finding_readouts();
  options.lenses = RigLenses::fixed;
  for (const RigCamera& camera : exact.cameras)
    options.known.push_back({{nullptr, camera.data.truth->camera, {}}, 0});
  const RigDataset seen = with_noise(exact, 0.2, 1);
  const RigCalibration timed = calibrate_rig(seen, options);
  ASSERT_EQ(timed.status, Status::ok);
  expect_readouts(timed);
  EXPECT_LT(nees_of_extrinsics(exact, timed), 3);
  options.find_readouts = false;
  const auto error_of = [&](const RigCalibration& answer) {
    const auto& truth = exact.truth->camera_from_rig;
    return minus(truth[1] * truth[0].inverse(), answer.cameras[1].camera_from_rig).norm();
  };
  EXPECT_GT(error_of(calibrate_rig(seen, options)), 5 * error_of(timed));
}

// Each board of a picture is a view of its own, at the same time.
TEST(RigShutter, SeveralBoards) {
  const std::vector<PlacedBoard> boards = {{make_board(AprilGrid{3, 6, 0.088, 0.3, 0}), Pose()},
                                           {make_board(AprilGrid{3, 6, 0.088, 0.3, 100}),
                                            Pose(Eigen::Quaterniond::Identity(), {0.36, 0, 0.05})}};
  const RigDataset exact = rig_film(rising_ring(1), kReadout, 60, boards);
  const RigDataset seen = with_noise(exact, 0.2, 1);
  RigOptions options = finding_readouts();
  options.find_boards = true;
  const RigCalibration timed = calibrate_rig(seen, options);
  ASSERT_EQ(timed.status, Status::ok);
  expect_readouts(timed);
  for (const RigCameraEstimate& camera : timed.cameras)
    EXPECT_EQ(camera.own.readout->num_views, 120);
  EXPECT_LT(nees_of_extrinsics(exact, timed), 3);
}

TEST(RigShutter, WhatIsFoundNamesItsCamera) {
  RigDataset rig = with_noise(rig_film(hand_motion(1), 0, 40), 0.2, 1);
  for (double& time_s : rig.cameras[1].times_s) time_s *= 30;  // a picture a second
  RigOptions options = finding_readouts();
  const RigCalibration slow = calibrate_rig(rig, options);
  const auto found = std::ranges::find(slow.findings, "readout_not_observable", &Finding::code);
  ASSERT_NE(found, slow.findings.end());
  EXPECT_TRUE(found->sentence.starts_with("cam1: no picture has two neighbours"));
  options.calibrate.front().times_s = rig.cameras[0].times_s;
  EXPECT_THROW(calibrate_rig(rig, options), Error);
  options.calibrate.front().times_s.clear();
  rig.cameras[1].times_s.clear();
  EXPECT_THROW(calibrate_rig(rig, options), Error);
}

}  // namespace
}  // namespace tagcal
