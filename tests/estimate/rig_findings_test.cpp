// The findings of rigs, each by data that have this trouble, and the pair of cameras to show the
// board next.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "finding_cases.hpp"
#include "rig_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
namespace {

Said of_rig(const RigDataset& rig, const RigOptions& options = {}) {
  const RigCalibration c = calibrate_rig(rig, options);
  return {c.status, codes_of(c.findings)};
}

// A camera of three that is a centimetre from its place.
Said of_moved_member() {
  RigWorldOptions world;
  world.num_cameras = 3;
  const RigDataset rig = make_rig_world(9, world);
  KnownRig known;
  std::vector<ViewCorrespondences> seen;
  for (std::size_t c = 0; c < 3; ++c) {
    const Dataset& data = rig.cameras[c].data;
    known.cameras.push_back(
        {"", {nullptr, data.truth->camera, {}}, rig.truth->camera_from_rig[c], {}});
    seen.push_back(view_correspondences(data.views[*rig.instants[0].view[c]], data.boards));
  }
  Vector6d step = Vector6d::Zero();
  step[3] = 0.01;
  known.cameras[2].camera_from_rig = retract(known.cameras[2].camera_from_rig, step);
  const PoseEstimate pose = estimate_rig_pose(seen, known).rig;
  return {pose.status, codes_of(pose.findings)};
}

RigWorldOptions moving_rig(std::vector<double> offset) {
  RigWorldOptions world;
  world.smooth = true;
  world.period_s = 0.04;
  world.offset = std::move(offset);
  return world;
}

// The instants that a rule keeps.
RigDataset at_instants(RigDataset rig, const std::function<bool(std::size_t, std::size_t)>& has) {
  for (std::size_t t = 0; t < rig.instants.size(); ++t)
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      if (!has(t, c)) rig.instants[t].view[c].reset();
  return rig;
}

// The second camera has pictures of two other instants.
RigDataset with_exchanged_views() {
  RigDataset rig = make_rig_world(3);
  std::swap(rig.instants[4].view[1], rig.instants[20].view[1]);
  return rig;
}

// The corners of the second camera are off by 1.5 times their noise, differently in each picture.
RigDataset with_strained_views() {
  RigWorldOptions world;
  world.sigma_px = 0.1;
  RigDataset rig = make_rig_world(3, world);
  Random random(8);
  for (View& view : rig.cameras[1].data.views) {
    const Eigen::Vector2d shift(0.3 * random.normal(), 0.3 * random.normal());
    for (Observation& o : view.observations) o.pixel += shift;
  }
  return rig;
}

// With the true cameras, that of the first one and another exchanged.
RigOptions with_exchanged_cameras(const RigDataset& rig, std::size_t other = 1) {
  RigOptions options;
  options.lenses = RigLenses::fixed;
  for (const RigCamera& camera : rig.cameras)
    options.known.push_back({{nullptr, camera.data.truth->camera, {}}});
  std::swap(options.known[0], options.known[other]);
  return options;
}

// The second camera has pictures of half the size.
RigDataset of_two_sizes() {
  RigDataset rig = make_rig_world(3);
  Dataset& data = rig.cameras[1].data;
  data.image_size = data.truth->camera.image_size = {640, 400};
  return rig;
}

RigDataset in_turns() {
  return at_instants(make_rig_world(3), [](auto t, auto c) { return t % 2 == c; });
}

const Finding* finding_of(const RigCalibration& answer, std::string_view code) {
  const auto found = std::ranges::find(answer.findings, code, &Finding::code);
  return found == answer.findings.end() ? nullptr : &*found;
}

}  // namespace

std::vector<RigFindingCase> cases_of_rigs() {
  RigWorldOptions moved, turned, shuffled;
  moved.moved_camera = 1;
  turned.turned_share = 0.4;
  shuffled.shuffled = true;
  RigOptions find_clocks;
  find_clocks.find_clocks = true;
  const Board checkers = make_board(Checkerboard{8, 6, 0.06, 0.06});
  RigDataset one_view = make_rig_world(5);
  for (View& view : one_view.cameras[1].data.views) view.observations.resize(3);
  const auto rig = [](const RigDataset& data, const RigOptions& options = {}) {
    return [=] { return of_rig(data, options); };
  };
  const RigDataset two_sizes = of_two_sizes(), one_size = make_rig_world(3);
  return {
      {"camera_contradicts", of_moved_member},
      {"camera_moved", rig(make_rig_world(7, moved))},
      {"camera_without_answer", rig(one_view)},
      {"clock_corrected", rig(make_rig_world(5, moving_rig({0, 0.35})), find_clocks)},
      {"corner_order_differs", rig(make_rig_world(11, turned, checkers))},
      {"instants_rejected", rig(with_exchanged_views())},
      {"instants_strained", rig(with_strained_views())},
      {"not_connected", rig(in_turns())},
      {"not_synchronous", rig(make_rig_world(5, moving_rig({0, 0.35})))},
      {"pair_contradicts", rig(make_rig_world(9, shuffled))},
      {"single_instant",
       rig(at_instants(make_rig_world(3), [](auto t, auto c) { return t == 0 || c == 0; }))},
      {"sizes_swapped", rig(two_sizes, with_exchanged_cameras(two_sizes))},
      {"sizes_swapped", rig(one_size, with_exchanged_cameras(one_size))},
  };
}

namespace {

TEST(RigFindings, HaveDataThatCauseThem) {
  for (const RigFindingCase& c : cases_of_rigs()) {
    const Said said = c.say();
    EXPECT_TRUE(said.codes.contains(c.code)) << c.code << testing::PrintToString(said.codes);
  }
}

TEST(RigFindings, SwappedSizesNameBothCameras) {
  RigDataset rig = of_two_sizes();
  const RigCalibration answer = calibrate_rig(rig, with_exchanged_cameras(rig));
  EXPECT_EQ(answer.status, Status::no_consensus);
  ASSERT_EQ(answer.findings.size(), 1U);
  EXPECT_EQ(answer.findings[0].sentence,
            "the pictures of cam0 have the image size of the camera that is given for cam1: the "
            "folders or the camera files are exchanged");
  // A size that no camera has is an error.
  rig.cameras[0].data.image_size = {320, 200};
  EXPECT_THROW(calibrate_rig(rig, with_exchanged_cameras(rig)), Error);
}

TEST(RigFindings, NotConnectedNamesTheNearestPair) {
  // cam2 sees the board at the instants 7 and 20 only, cam0 until 5 and cam1 from 23 on.
  RigWorldOptions world;
  world.num_cameras = 3;
  RigDataset rig = make_rig_world(3, world);
  rig = at_instants(rig, [](auto t, auto c) {
    return c == 2 ? t == 7 || t == 20 : c == 0 ? t <= 5 || t == 29 : t >= 23;
  });
  const RigCalibration answer = calibrate_rig(rig);
  EXPECT_EQ(answer.status, Status::not_connected);
  const Finding* const finding = finding_of(answer, "not_connected");
  ASSERT_NE(finding, nullptr);
  EXPECT_NE(finding->sentence.find(
                "nearest are cam0 and cam2, at the instants 5 and 7, 2 instants apart"),
            std::string::npos)
      << finding->sentence;
  ASSERT_TRUE(answer.next);
  EXPECT_EQ(answer.next->a, 0u);
  EXPECT_EQ(answer.next->b, 2u);
  EXPECT_EQ(answer.next->sentence, "show the board to cam0 and cam2 at the same time");
  EXPECT_TRUE(std::isinf(answer.next->sigma_px));
}

// A view at the advised place improves the pair more than one more view at a place where the board
// was.
TEST(RigFindings, TheAdvisedPairIsTheOneWithTheFewestInstants) {
  RigWorldOptions world;
  world.num_cameras = 3;
  world.fisheyes = false;
  // cam2 has five instants with the others.
  const RigDataset rig =
      at_instants(make_rig_world(3, world), [](auto t, auto c) { return c < 2 || t % 6 == 0; });
  const RigCalibration answer = calibrate_rig(rig);
  ASSERT_EQ(answer.status, Status::ok);
  ASSERT_TRUE(answer.next);
  EXPECT_EQ(answer.next->b, 2U);
  EXPECT_GT(answer.next->sigma_px, 0);
  EXPECT_LT(answer.next->sigma_px, 10);
  EXPECT_GT(answer.next->distance_m, 0.3);
  EXPECT_NE(answer.next->sentence.find("and cam2 at the same time"), std::string::npos)
      << answer.next->sentence;
}

// Focal lengths of 944.7 and 959.3 px with corners of half a pixel: a few views do not tell them
// apart, and the lenses are taken as exact, so an answer would be silently wrong.
TEST(RigFindings, ExchangedLensesThatAreNearlyEqualAreNamed) {
  const RigDataset rig = make_rig_world(70646, {.num_cameras = 6,
                                                .num_instants = 47,
                                                .sigma_px = 0.499166,
                                                .smooth = true,
                                                .seen_share = 0.826482});
  const RigCalibration answer = calibrate_rig(rig, with_exchanged_cameras(rig, 2));
  ASSERT_NE(finding_of(answer, "sizes_swapped"), nullptr);
  EXPECT_NE(finding_of(answer, "sizes_swapped")->sentence.find("given for cam2"),
            std::string::npos);
}

}  // namespace
}  // namespace tagcal
