#include "tagcal/estimate/calibrate_rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "calibrations.hpp"
#include "rig_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/scene/rig_pairing.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal {
namespace {

RigOptions named(std::string model) {
  RigOptions options;
  options.calibrate.front().model = std::move(model);
  return options;
}

TEST(CalibrateRig, FindsTheTruthWithoutNoise) {
  RigWorldOptions world;
  world.num_cameras = 3;
  world.sigma_px = 0;
  world.seen_share = 0.8;
  const RigDataset rig = make_rig_world(1, world);
  const RigCalibration answer = calibrate_rig(rig);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_LT(minus(rig.truth->camera_from_rig[c], answer.cameras[c].camera_from_rig).norm(), 1e-6);
}

TEST(CalibrateRig, ClaimsWhatItIsOffBy) {
  double sum = 0;
  constexpr int kRigs = 24;
  for (int seed = 0; seed < kRigs; ++seed) {
    RigWorldOptions world;
    world.num_cameras = 2 + seed % 3;
    world.with_covariances = seed % 2 == 1;
    const RigDataset rig = make_rig_world(100 + static_cast<std::uint64_t>(seed), world);
    const RigCalibration answer = calibrate_rig(rig, named("opencv5"));
    ASSERT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    const double nees = nees_of_extrinsics(rig, answer);
    EXPECT_LT(nees, 3) << seed;
    sum += nees;
  }
  EXPECT_GT(sum / kRigs, 0.6);
  EXPECT_LT(sum / kRigs, 1.1);
}

TEST(CalibrateRig, LensesThatAreHeldCountInTheClaims) {
  double sum = 0;
  constexpr int kRigs = 12;
  for (int seed = 0; seed < kRigs; ++seed) {
    const RigDataset rig = make_rig_world(200 + static_cast<std::uint64_t>(seed));
    RigOptions options;
    options.lenses = RigLenses::fixed;
    for (const RigCamera& camera : rig.cameras) {
      const Calibration own = calibrate(camera.data);
      options.known.push_back({*own.claim, camera_error_px(own)});
    }
    const RigCalibration answer = calibrate_rig(rig, options);
    ASSERT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    EXPECT_EQ(parameters(answer.cameras[1].camera.camera.lens)[0],
              parameters(options.known[1].camera.camera.lens)[0]);
    sum += nees_of_extrinsics(rig, answer);
  }
  EXPECT_GT(sum / kRigs, 0.4);
  EXPECT_LT(sum / kRigs, 1.3);
}

TEST(CalibrateRig, PicturesOfOtherTimesAreRefused) {
  for (const double offset : {0.3, -0.6, 1.0, 2.0, -3.0}) {
    RigWorldOptions world;
    world.smooth = true;
    world.num_cameras = 3;
    world.offset = {0, offset, 0};
    const RigCalibration answer = calibrate_rig(make_rig_world(3, world));
    EXPECT_EQ(answer.status, Status::not_synchronous) << offset << all_sentences(answer);
    // The reference may be the one that is off.
    world.offset = {offset, 0, 0};
    const RigCalibration reference = calibrate_rig(make_rig_world(3, world));
    EXPECT_FALSE(is_answer(reference.status)) << offset << all_sentences(reference);
  }
}

// The second camera takes its pictures 0.35 of a period of 0.04 s later.
RigDataset film_with_a_late_camera(int num_instants) {
  RigWorldOptions world;
  world.smooth = true;
  world.num_instants = num_instants;
  world.period_s = 0.04;
  world.offset = {0, 0.35};
  return make_rig_world(5, world);
}

void find_late_clock(const RigDataset& rig, RigCalibration& answer) {
  RigOptions options;
  options.find_clocks = true;
  answer = calibrate_rig(rig, options);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  ASSERT_EQ(answer.clocks.size(), 1U);
  EXPECT_NEAR(answer.clocks[0].offset, 0.35 * 0.04, 0.0005);
}

TEST(CalibrateRig, ClocksAreFoundByTheBoardsMotion) {
  const RigDataset rig = film_with_a_late_camera(60);
  EXPECT_EQ(calibrate_rig(rig).status, Status::not_synchronous);
  RigCalibration answer;
  ASSERT_NO_FATAL_FAILURE(find_late_clock(rig, answer));
  EXPECT_LT(nees_of_extrinsics(rig, answer), 3);
}

// No camera sees the board for a while: the film behind it counts.
TEST(CalibrateRig, ClocksAreFoundByAllPartsOfAFilm) {
  RigDataset rig = film_with_a_late_camera(80);
  for (Instant& instant : rig.instants) {
    const auto t = &instant - rig.instants.data();
    if (t >= 35 && t < 45) std::ranges::fill(instant.view, std::nullopt);
  }
  RigCalibration answer;
  ASSERT_NO_FATAL_FAILURE(find_late_clock(rig, answer));
  EXPECT_GE(answer.pairs[0].num_instants, 55);
}

TEST(CalibrateRig, ACameraThatMovedIsNamed) {
  RigWorldOptions world;
  world.moved_camera = 1;
  world.num_cameras = 3;
  const RigCalibration answer = calibrate_rig(make_rig_world(7, world));
  EXPECT_TRUE(has(answer, "camera_moved")) << all_sentences(answer);
  EXPECT_EQ(answer.status, Status::ok);
  EXPECT_NE(all_sentences(answer).find("cam1 moved against the others at instant 15"),
            std::string::npos)
      << all_sentences(answer);
}

TEST(CalibrateRig, WrongPairsAreRefused) {
  RigWorldOptions world;
  world.shuffled = true;
  const RigCalibration answer = calibrate_rig(make_rig_world(9, world));
  EXPECT_EQ(answer.status, Status::no_consensus) << all_sentences(answer);
  EXPECT_TRUE(has(answer, "pair_contradicts"));
}

TEST(CalibrateRig, BoardsReadFromTheirOtherSideAreTurned) {
  RigWorldOptions world;
  world.num_cameras = 3;
  world.turned_share = 0.4;
  const RigDataset rig = make_rig_world(11, world, make_board(Checkerboard{8, 6, 0.06, 0.06}));
  const RigCalibration answer = calibrate_rig(rig);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  EXPECT_TRUE(has(answer, "corner_order_differs"));
  EXPECT_TRUE(answer.rejected_instants.empty());
  EXPECT_LT(nees_of_extrinsics(rig, answer), 3);
}

TEST(CalibrateRig, GroupsWithoutACommonInstantAreNamed) {
  RigWorldOptions world;
  world.num_cameras = 3;
  RigDataset rig = make_rig_world(13, world);
  for (std::size_t t = 0; t < rig.instants.size(); ++t)
    if (t % 2 == 0)
      rig.instants[t].view[2].reset();
    else
      rig.instants[t].view[0] = rig.instants[t].view[1] = std::nullopt;
  const RigCalibration answer = calibrate_rig(rig);
  EXPECT_EQ(answer.status, Status::not_connected);
  EXPECT_EQ(answer.groups, (std::vector<std::vector<std::size_t>>{{0, 1}, {2}}));
  EXPECT_TRUE(answer.cameras[1].is_connected);
  EXPECT_FALSE(answer.cameras[2].is_connected);
}

// The errors of the lenses' parameters in their standard deviations: the answer and the covariance
// both combine each camera's own claim with what the rig adds.
TEST(CalibrateRig, LensesAreWithinTheirClaims) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 100; seed < 112; ++seed) {
    RigWorldOptions options;
    options.num_instants = 12;
    options.fisheyes = false;
    const RigDataset rig = make_rig_world(seed, options);
    const RigCalibration answer = calibrate_rig(rig);
    ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
    for (std::size_t c = 0; c < 2; ++c) {
      const UncertainCamera& camera = answer.cameras[c].camera;
      const auto estimate = parameters(camera.camera.lens);
      const auto truth = parameters(rig.cameras[c].data.truth->camera.lens);
      const std::vector<double> sigmas = lens_sigmas(camera);
      for (std::size_t i = 0; i < sigmas.size(); ++i) {
        if (!(sigmas[i] > 0)) continue;
        const double z = (estimate[i] - truth[i]) / sigmas[i];
        EXPECT_LT(std::abs(z), 5) << seed << " " << i;
        sum += z * z;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 150);
  EXPECT_LT(sum / count, 1.4);
  EXPECT_GT(sum / count, 0.3);
}

TEST(CalibrateRig, ViewsOfNoInstantInformTheLensOnly) {
  RigDataset rig = make_rig_world(3);
  for (std::size_t t = 1; t < rig.instants.size(); ++t) rig.instants[t].view[1].reset();
  const RigCalibration answer = calibrate_rig(rig);
  EXPECT_EQ(answer.status, Status::ok) << all_sentences(answer);
  EXPECT_TRUE(has(answer, "single_instant"));
  EXPECT_LT(nees_of_extrinsics(rig, answer), 4);
}

TEST(CalibrateRig, AnyReferenceAndAnyNumberOfThreads) {
  RigWorldOptions world;
  world.num_cameras = 3;
  const RigDataset rig = make_rig_world(15, world);
  RigOptions options = named("opencv5");
  const RigCalibration first = calibrate_rig(rig, options);
  EXPECT_TRUE(first.findings.empty()) << all_sentences(first);
  options.calibrate.front().num_threads = 4;
  EXPECT_EQ(calibrate_rig(rig, options).covariance, first.covariance);
  options.reference = 2;
  const RigCalibration other = calibrate_rig(rig, options);
  const Pose pair = other.cameras[1].camera_from_rig * other.cameras[0].camera_from_rig.inverse();
  EXPECT_LT(minus(pair, first.cameras[1].camera_from_rig).norm(), 1e-6);
  EXPECT_NEAR(other.pairs[0].sigma_baseline_m / first.pairs[0].sigma_baseline_m, 1, 0.02);
}

TEST(CalibrateRig, KnownLensesMayBeExact) {
  const RigDataset rig = make_rig_world(3);
  RigOptions options;
  options.lenses = RigLenses::fixed;
  for (const RigCamera& camera : rig.cameras)
    options.known.push_back({{nullptr, camera.data.truth->camera, {}}});
  const RigCalibration answer = calibrate_rig(rig, options);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  EXPECT_EQ(answer.covariance.rows(), 6);
  EXPECT_LT(nees_of_extrinsics(rig, answer), 4);
  ASSERT_FALSE(answer.pairs.front().depths.empty());
  EXPECT_EQ(answer.pairs.front().depths.front().of_lenses_m, 0);
}

TEST(CalibrateRig, AnOffsetThatIsNotCorrectedIsWithinItsClaim) {
  for (const double offset : {-3.0, -0.5, 0.1, 0.3, 0.6, 1.0, 2.0})
    for (const std::uint64_t seed : {1, 2, 3}) {
      RigWorldOptions world;
      world.smooth = true;
      world.offset = {0, offset};
      const RigCalibration answer = calibrate_rig(make_rig_world(seed, world));
      ASSERT_EQ(answer.clocks.size(), 1U) << offset << all_sentences(answer);
      EXPECT_NEAR(answer.clocks[0].offset, offset, 4 * answer.clocks[0].sigma) << seed;
      EXPECT_NEAR(answer.clocks[0].offset, offset, 0.01) << seed;
    }
}

TEST(CalibrateRig, CamerasWithoutACommonViewAreConnectedByTheirMotions) {
  RigOptions options = named("opencv5");
  options.find_boards = true;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const RigDataset rig = back_to_back(3, seed);
    const RigCalibration answer = calibrate_rig(rig, options);
    ASSERT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    EXPECT_LT(nees_of_extrinsics(rig, answer), 4) << seed;
    ASSERT_EQ(answer.boards.size(), 2U);
    const std::vector<PlacedBoard>& truth = rig.cameras[0].data.boards;
    EXPECT_LT(distance_between_m(truth[1].world_from_board, answer.boards[1].world_from_board),
              0.01);
  }
}

TEST(CalibrateRig, AWheelDoesNotTellThePlaceAlongItsAxis) {
  RigOptions options = named("opencv5");
  options.find_boards = true;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const RigCalibration answer = calibrate_rig(back_to_back(1, seed), options);
    EXPECT_EQ(answer.status, Status::extrinsic_not_observable) << seed << all_sentences(answer);
  }
}

TEST(CalibrateRig, BoardsOfUnknownPlacesArePlaced) {
  // The second board is turned by 40 degrees beside the first one; both are seen together.
  RigWorldOptions world;
  world.num_cameras = 2;
  RigDataset rig = make_rig_world(21, world);
  const Board second = make_board(AprilGrid{4, 4, 0.05, 0.3, 200});
  const Pose place(exp_rotation({0, 0.7, 0}), {0.75, 0.1, 0.05});
  std::vector<TargetPoint> points = target_points(second);
  for (TargetPoint& p : points) p.position = place * p.position;
  Random random(5);
  WorldOptions corners;
  corners.sigma_px = world.sigma_px;
  for (std::size_t c = 0; c < 2; ++c) {
    Dataset& data = rig.cameras[c].data;
    data.boards.push_back({second, Pose()});  // unknown
    for (View& view : data.views) {
      // The pose by the first board's corners.
      Dataset only = data;
      only.boards.pop_back();
      const PoseEstimate pose =
          estimate_pose(view_correspondences(view, only.boards), data.truth->camera);
      ASSERT_TRUE(is_answer(pose.status));
      const View more =
          observe(data.truth->camera, pose.camera_from_target(), points, corners, random);
      view.observations.insert(view.observations.end(), more.observations.begin(),
                               more.observations.end());
    }
  }
  RigOptions options = named("opencv5");
  options.find_boards = true;
  const RigCalibration answer = calibrate_rig(rig, options);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  EXPECT_LT(distance_between_m(place, answer.boards[1].world_from_board), 0.002);
  EXPECT_LT(angle_between_rad(place, answer.boards[1].world_from_board), 0.003);
}

TEST(CalibrateRig, BadInputThrows) {
  EXPECT_THROW(calibrate_rig({}), Error);
  RigDataset rig = make_rig_world(17);
  RigOptions options;
  options.reference = 2;
  EXPECT_THROW(calibrate_rig(rig, options), Error);
  options = {};
  options.find_clocks = true;
  EXPECT_THROW(calibrate_rig(rig, options), Error);
  options = {};
  options.lenses = RigLenses::fixed;
  EXPECT_THROW(calibrate_rig(rig, options), Error);
  rig.instants[0].view[1] = 1000;
  EXPECT_THROW(calibrate_rig(rig), Error);
}

TEST(CalibrateRig, EurocsPairHasItsPublishedBaseline) {
  const std::filesystem::path set = TAGCAL_SOURCE_DIR "/../shared/real/euroc";
  if (!std::filesystem::exists(set)) GTEST_SKIP() << "needs real data";
  RigDataset rig;
  for (const char* name : {"cam_april-cam0", "cam_april-cam1"})
    rig.cameras.push_back({name, read_dataset(set / name).dataset, {}});
  rig.instants = pair_by_name(rig.cameras);
  const RigCalibration answer = calibrate_rig(rig);
  ASSERT_EQ(answer.status, Status::ok) << all_sentences(answer);
  const RigPair& pair = answer.pairs.front();
  EXPECT_NEAR(pair.baseline_m, 0.11008, 3 * pair.sigma_baseline_m);
  EXPECT_LT(pair.sigma_baseline_m, 0.001);
}

}  // namespace
}  // namespace tagcal
