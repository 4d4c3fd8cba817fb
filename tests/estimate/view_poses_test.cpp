// Poses of views under a camera that is known, and rigs of such cameras: the noise comes from the
// residuals of all views.
#include <gtest/gtest.h>

#include "rig_worlds.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
namespace {

constexpr std::size_t kFew = 12;  // corners, of which a view alone does not show its noise

Dataset world_of_few_corners(int num_views, double sigma_px) {
  WorldOptions options;
  options.num_views = num_views;
  options.sigma_px = sigma_px;
  Dataset world = make_world(opencv5_lens(), 3, options);
  for (View& view : world.views) view.observations.resize(kFew);
  return world;
}

TEST(ViewPoses, ShareTheirNoise) {
  const Dataset world = world_of_few_corners(20, 0.1);
  const ViewPoses poses = poses_of_views(world, {opencv5_lens(), world.image_size}, {});
  EXPECT_EQ(poses.views.size(), 20U);
  EXPECT_EQ(poses.pixels.size() + poses.outliers.size(), 20 * kFew);
  EXPECT_NEAR(poses.sigma_px, 0.1, 0.012);  // three standard deviations of 360 residuals
  EXPECT_TRUE(poses.findings.empty());
  const ViewPoses threads = poses_of_views(world, {opencv5_lens(), world.image_size}, {}, 2);
  EXPECT_EQ(threads.sigma_px, poses.sigma_px);
}

TEST(ViewPoses, SayThatTheNoiseIsAssumed) {
  const Dataset world = world_of_few_corners(2, 0.1);
  const ViewPoses poses = poses_of_views(world, {opencv5_lens(), world.image_size}, {});
  EXPECT_EQ(poses.sigma_px, 0.5);
  ASSERT_EQ(poses.findings.size(), 1U);
  EXPECT_EQ(poses.findings[0].code, "noise_assumed");
}

TEST(ViewPoses, NameWrongCornersByTheirPlaceInTheView) {
  Dataset world = make_world(opencv5_lens(), 3, {});
  world.views[4].observations[7].pixel.x() += 30;
  // An id that no board has is no corner, and keeps its place.
  world.views[4].observations[2].id.tag_id = 4000;
  const std::array<std::size_t, 2> views = {4, 1};
  const ViewPoses poses = poses_of_views(world, views, {opencv5_lens(), world.image_size}, {});
  ASSERT_EQ(poses.views.size(), 2U);
  EXPECT_EQ(poses.views[0].view, 4U);
  ASSERT_EQ(poses.outliers.size(), 1U);
  EXPECT_EQ(poses.outliers[0].view, 4U);
  EXPECT_EQ(poses.outliers[0].corner, 7U);
  EXPECT_NEAR(poses.outliers[0].residual_px, 30, 1);
}

RigDataset rig_of_few_corners(std::uint64_t seed) {
  RigDataset rig = make_rig_world(seed);
  for (RigCamera& camera : rig.cameras)
    for (View& view : camera.data.views)
      view.observations.resize(std::min(view.observations.size(), kFew));
  return rig;
}

RigCalibration by_exact_lenses(const RigDataset& rig, double error_px = 0) {
  RigOptions options;
  options.lenses = RigLenses::fixed;
  for (const RigCamera& camera : rig.cameras)
    options.known.push_back({{nullptr, camera.data.truth->camera, {}}, error_px});
  return calibrate_rig(rig, options);
}

// 0.5 px would be assumed for each view by itself: of 0.2 px, NEES 0.16.
TEST(KnownLenses, FewCornersInEachViewShowTheNoiseOfARig) {
  double sum = 0;
  constexpr int kRigs = 12;
  for (int seed = 0; seed < kRigs; ++seed) {
    const RigDataset rig = rig_of_few_corners(300 + static_cast<std::uint64_t>(seed));
    const RigCalibration answer = by_exact_lenses(rig);
    ASSERT_TRUE(is_answer(answer.status)) << seed;
    sum += nees_of_extrinsics(rig, answer);
  }
  EXPECT_GT(sum / kRigs, 0.5);
  EXPECT_LT(sum / kRigs, 1.5);
}

// A focal length that is 1 % off costs most of the instants, and the places follow it.
TEST(KnownLenses, ThatThePicturesContradictAreNamed) {
  const RigDataset rig = make_rig_world(320);
  for (const double factor : {1.0, 1.01}) {
    RigOptions options;
    options.lenses = RigLenses::fixed;
    for (const RigCamera& camera : rig.cameras) {
      const Calibration own = calibrate(camera.data);
      UncertainCamera known = *own.claim;
      const auto before = parameters(known.camera.lens);
      std::vector<double> values(before.begin(), before.end());
      values[0] *= factor;
      values[1] *= factor;
      known.camera.lens = make_lens(kind_of(known.camera.lens), values);
      options.known.push_back({known, camera_error_px(own)});
    }
    const RigCalibration answer = calibrate_rig(rig, options);
    const auto changed = std::ranges::count(answer.findings, "camera_changed", &Finding::code);
    EXPECT_EQ(changed, factor == 1 ? 0 : std::ssize(rig.cameras)) << factor;
  }
}

// The corners of a set have covariances, or they have not: a single view does not decide.
TEST(KnownLenses, OneViewWithoutCovariancesChangesLittle) {
  RigWorldOptions world;
  world.with_covariances = true;
  RigDataset rig = make_rig_world(310, world);
  const MatrixX all = by_exact_lenses(rig, 0).covariance;
  for (RigCamera& camera : rig.cameras)
    for (Observation& corner : camera.data.views.back().observations) corner.covariance_px2.reset();
  const MatrixX some = by_exact_lenses(rig, 0).covariance;
  ASSERT_EQ(all.rows(), some.rows());
  for (Eigen::Index i = 0; i < all.rows(); ++i) EXPECT_NEAR(some(i, i) / all(i, i), 1, 0.2) << i;
}

}  // namespace
}  // namespace tagcal
