#include "tagcal/estimate/calibrate_rig.hpp"

#include <gtest/gtest.h>

#include "rig_worlds.hpp"

namespace tagcal {
namespace {

bool has(const RigCalibration& answer, std::string_view code) {
  return std::ranges::any_of(answer.findings, [&](const Finding& f) { return f.code == code; });
}

std::string all_sentences(const RigCalibration& answer) {
  std::string all;
  for (const Finding& f : answer.findings) all += f.code + ": " + f.sentence + "\n";
  return all;
}

RigOptions named(std::string model) {
  RigOptions options;
  options.camera.model = std::move(model);
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
  constexpr int kRigs = 30;
  for (int seed = 0; seed < kRigs; ++seed) {
    RigWorldOptions world;
    world.num_cameras = 2 + seed % 3;
    world.with_covariances = seed % 2 == 1;
    const RigDataset rig = make_rig_world(100 + static_cast<std::uint64_t>(seed), world);
    const RigCalibration answer = calibrate_rig(rig);
    ASSERT_EQ(answer.status, Status::ok) << seed << all_sentences(answer);
    const double nees = nees_of_extrinsics(rig, answer);
    std::printf("%d: nees %.2f excess %.2f %.4f s\n", seed, nees, answer.cameras[1].excess,
                answer.seconds);
    sum += nees;
  }
  EXPECT_GT(sum / kRigs, 0.6);
  EXPECT_LT(sum / kRigs, 1.1);
}

}  // namespace
}  // namespace tagcal
