#include "tagcal/validate/validate.hpp"

#include <gtest/gtest.h>

#include "worlds.hpp"

namespace tagcal {
namespace {

TEST(Validate, AgreesWithOpenCVAndTheTruth) {
  for (const Lens& lens : {opencv5_lens(), fisheye_lens()}) {
    const Dataset world = make_world(lens, 1);
    const Validation v =
        validate(world.truth->camera, std::vector<double>(parameters(lens).size(), 1), world);
    EXPECT_TRUE(v.opencv_agrees);
    EXPECT_EQ(v.num_beyond_truth, 0);
    EXPECT_EQ(v.num_without_pose, 0);
    EXPECT_EQ(v.num_views, 20);
    EXPECT_GT(v.num_compared, 2000);
    EXPECT_LT(v.max_projection_difference_px, v.bound_px);
    EXPECT_LT(v.max_jacobian_difference, 1e-6);
    EXPECT_NEAR(v.rms_px, 0.2 * std::sqrt(2.0), 0.02);
    ASSERT_EQ(v.parameters.size(), parameters(lens).size());
    for (const ParameterError& p : v.parameters) EXPECT_EQ(p.in_sigmas.value_or(0), 0);
  }
}

TEST(Validate, CountsErrorsInStandardDeviations) {
  const Dataset world = make_world(opencv5_lens(), 2);
  Camera camera = world.truth->camera, below = world.truth->camera;
  below.lens = Perspective({897, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0});
  camera.lens = Perspective({903, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0});
  const Validation v = validate(camera, {1.5, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0}, world);
  EXPECT_DOUBLE_EQ(v.parameters[0].in_sigmas.value(), 2);
  EXPECT_EQ(v.parameters[1].in_sigmas, 0);
  EXPECT_EQ(v.num_beyond_truth, 0);
  EXPECT_EQ(validate(below, {0.5, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0}, world).num_beyond_truth, 1);
  EXPECT_EQ(validate(camera, {0.5, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0}, world).num_beyond_truth, 1);
  EXPECT_FALSE(v.parameters[9].in_sigmas);  // held
  const Validation unknown = validate(camera, {}, world);
  EXPECT_FALSE(unknown.num_beyond_truth || unknown.parameters[0].sigma);
}

// Corners that claim less noise than lens and target are wrong by: the camera's error is part of
// what a residual may be, as for `tagcal pose`.
TEST(Validate, CountsTheCamerasError) {
  Dataset world = make_world(opencv5_lens(), 4);
  for (View& view : world.views)
    for (Observation& o : view.observations) o.covariance_px2 = 0.01 * 0.01 * Matrix2::Identity();
  const Validation with = validate(world.truth->camera, {}, world, 0.2);
  EXPECT_EQ(with.num_views, 20);
  EXPECT_EQ(with.num_without_pose, 0);
  EXPECT_LT(validate(world.truth->camera, {}, world, 0.0).num_views, 20);
}

TEST(Validate, NothingComparedIsNotPassed) {
  Dataset world = make_world(opencv5_lens(), 3);
  world.views.clear();
  EXPECT_FALSE(validate(world.truth->camera, {}, world).opencv_agrees);
}

}  // namespace
}  // namespace tagcal
