#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "calibrations.hpp"
#include "rig_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
namespace {

// The true rig of a world, with what its cameras saw at an instant.
struct SeenRig {
  RigDataset world;
  KnownRig rig;

  SeenRig(std::uint64_t seed, const RigWorldOptions& options, const Board& board = usual_board())
      : world(make_rig_world(seed, options, board)) {
    for (std::size_t c = 0; c < world.cameras.size(); ++c)
      rig.cameras.push_back({world.cameras[c].name,
                             {nullptr, world.cameras[c].data.truth->camera, {}},
                             world.truth->camera_from_rig[c],
                             0});
  }

  std::vector<ViewCorrespondences> at(std::size_t instant) const {
    std::vector<ViewCorrespondences> seen(rig.cameras.size());
    for (std::size_t c = 0; c < seen.size(); ++c)
      if (const auto& view = world.instants[instant].view[c])
        seen[c] = view_correspondences(world.cameras[c].data.views[*view],
                                       world.cameras[c].data.boards, 0);
    return seen;
  }

  // The pose of the rig, by the corners of its first camera that sees the board.
  Pose truth(std::size_t instant) const {
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      if (const auto& view = world.instants[instant].view[c])
        return rig.cameras[c].camera_from_rig.inverse() *
               estimate_pose(view_correspondences(world.cameras[c].data.views[*view],
                                                  world.cameras[c].data.boards),
                             rig.cameras[c].camera.camera)
                   .camera_from_target();
    return {};
  }
};

RigWorldOptions options_of(int num_cameras, double sigma_px) {
  RigWorldOptions options;
  options.num_cameras = num_cameras;
  options.num_instants = 40;
  options.sigma_px = sigma_px;
  options.with_covariances = true;
  return options;
}

TEST(RigPose, IsExactWithoutNoise) {
  RigWorldOptions options = options_of(3, 0);
  options.with_covariances = false;
  const SeenRig seen(5, options);
  for (std::size_t t = 0; t < 5; ++t) {
    const RigPoseEstimate pose = estimate_rig_pose(seen.at(t), seen.rig);
    ASSERT_EQ(pose.rig.status, Status::ok);
    EXPECT_LT(minus(pose.rig.camera_from_target(), seen.truth(t)).norm(), 1e-9);
  }
}

// The mean square of the errors in standard deviations, over 40 instants of a rig whose cameras are
// at other places than their file says, by its covariance.
double nees(double sigma_rad, double sigma_m) {
  double sum = 0;
  int count = 0;
  const SeenRig exact(11, options_of(3, 1e-9));
  const SeenRig noisy(11, options_of(3, 0.1));
  KnownRig rig = noisy.rig;
  Random random(3);
  rig.covariance = MatrixX::Zero(18, 18);
  for (std::size_t t = 0; t < 40; ++t) {
    for (std::size_t c = 1; c < 3; ++c) {
      Vector6d step;
      for (int i = 0; i < 6; ++i) {
        const double sigma = i < 3 ? sigma_rad : sigma_m;
        step[i] = sigma * random.normal();
        const Eigen::Index at = 6 * static_cast<Eigen::Index>(c) + i;
        rig.covariance(at, at) = sigma * sigma;
      }
      rig.cameras[c].camera_from_rig = retract(noisy.rig.cameras[c].camera_from_rig, step);
    }
    const RigPoseEstimate pose = estimate_rig_pose(noisy.at(t), rig);
    if (!is_answer(pose.rig.status)) continue;
    const PoseHypothesis& best = pose.rig.hypotheses.front();
    const Vector6d error = minus(exact.truth(t), best.camera_from_target);
    const Eigen::Matrix<double, 6, 6> covariance = best.covariance;
    sum += error.dot(covariance.ldlt().solve(error)) / 6;
    ++count;
  }
  EXPECT_GE(count, 35);
  return sum / count;
}

// 240 numbers: a standard deviation of 0.09.
TEST(RigPose, CovarianceHolds) {
  EXPECT_NEAR(nees(0, 0), 1, 0.27);
  EXPECT_NEAR(nees(2e-4, 2e-4), 1, 0.27);
  // Places that are known less well than a camera knows its pose are no contradiction.
  EXPECT_NEAR(nees(2e-3, 1e-3), 1, 0.27);
}

// The probability of the hypothesis that is next to the truth.
double probability_of(const PoseEstimate& pose, const Pose& truth) {
  const auto next =
      std::ranges::min_element(pose.hypotheses, {}, [&](const PoseHypothesis& hypothesis) {
        return angle_between_rad(hypothesis.camera_from_target, truth);
      });
  return next->probability;
}

TEST(RigPose, TheSecondCameraResolvesThePosesOfATag) {
  const Board tags = make_board(AprilGrid{2, 1, 0.02, 0.3});
  RigWorldOptions options = options_of(2, 0.3);
  options.fisheyes = false;
  const SeenRig seen(7, options, tags);
  options.sigma_px = 1e-9;
  const SeenRig exact(7, options, tags);
  int num_ambiguous = 0, num_resolved = 0;
  double of_rig = 0, of_first = 0;
  for (std::size_t t = 0; t < 40; ++t) {
    const RigPoseEstimate pose = estimate_rig_pose(seen.at(t), seen.rig);
    const PoseEstimate& first = pose.of_cameras[0];
    if (first.status != Status::ambiguous || pose.of_cameras[1].status != Status::ambiguous)
      continue;
    ++num_ambiguous;
    if (pose.rig.status == Status::ok) ++num_resolved;
    const Pose truth = exact.truth(t);
    of_rig += probability_of(pose.rig, truth);
    of_first += probability_of(first, seen.rig.cameras[0].camera_from_rig * truth);
  }
  EXPECT_GE(num_ambiguous, 5);
  EXPECT_GE(4 * num_resolved, num_ambiguous);
  EXPECT_GT(of_rig, of_first);
}

TEST(RigPose, ACameraThatMovedIsLeftOut) {
  SeenRig seen(9, options_of(3, 0.1));
  seen.rig.cameras[2].camera_from_rig =
      retract(seen.rig.cameras[2].camera_from_rig, (Vector6d() << 0, 0, 0, 0.01, 0, 0).finished());
  const RigPoseEstimate pose = estimate_rig_pose(seen.at(0), seen.rig);
  EXPECT_EQ(pose.rig.status, Status::ok);
  EXPECT_EQ(pose.takes_part, (std::vector<std::uint8_t>{1, 1, 0}));
  EXPECT_TRUE(has(pose.rig, "camera_contradicts"));
}

TEST(RigPose, TwoCamerasThatContradictGiveNoAnswer) {
  SeenRig seen(9, options_of(2, 0.1));
  seen.rig.cameras[1].camera_from_rig =
      retract(seen.rig.cameras[1].camera_from_rig, (Vector6d() << 0, 0, 0, 0.01, 0, 0).finished());
  const RigPoseEstimate pose = estimate_rig_pose(seen.at(0), seen.rig);
  EXPECT_EQ(pose.rig.status, Status::no_consensus);
  EXPECT_TRUE(has(pose.rig, "pair_contradicts"));
  EXPECT_THROW(pose.rig.camera_from_target(), Error);
}

TEST(RigPose, OneCameraIsEnough) {
  const SeenRig seen(13, options_of(2, 0.1));
  std::vector<ViewCorrespondences> corners = seen.at(0);
  corners[0] = {};
  const RigPoseEstimate pose = estimate_rig_pose(corners, seen.rig);
  ASSERT_EQ(pose.rig.status, Status::ok);
  EXPECT_LT(minus(seen.rig.cameras[1].camera_from_rig * pose.rig.camera_from_target(),
                  pose.of_cameras[1].camera_from_target())
                .norm(),
            1e-12);
  EXPECT_EQ(pose.takes_part, (std::vector<std::uint8_t>{0, 1}));
}

TEST(RigPose, NothingSeenIsNoAnswer) {
  const SeenRig seen(13, options_of(2, 0.1));
  const RigPoseEstimate pose = estimate_rig_pose(std::vector<ViewCorrespondences>(2), seen.rig);
  EXPECT_TRUE(has(pose.rig, "target_unseen"));
  EXPECT_THROW(estimate_rig_pose(std::vector<ViewCorrespondences>(3), seen.rig), Error);
}

}  // namespace
}  // namespace tagcal
