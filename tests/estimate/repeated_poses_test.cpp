#include "tagcal/estimate/bundle/repeated_poses.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using internal::Bundle;

const Lens kHeldLens = Perspective({900, 900, 639.5, 399.5, -0.1});
const WorldOptions kEight = {.num_views = 8};

// The views of a world, each one several times, from cameras that move by `move_m` between them.
// `common`: the share of the noise's variance that the views of a pose have in common.
Dataset repeated(std::uint64_t seed, const WorldOptions& options, int times, double move_m,
                 double common) {
  WorldOptions exact = options;
  exact.sigma_px = 0;
  Dataset world = make_world(kHeldLens, seed, exact);
  const auto points = target_points(world.boards[0].board);
  Random random(seed + 1000);
  const std::map<std::string, Pose> poses = std::exchange(world.truth->camera_from_world, {});
  world.views.clear();
  for (const auto& [name, pose] : poses) {
    std::map<CornerId, Eigen::Vector2d> shared;
    for (const TargetPoint& p : points) shared[p.id] = {random.normal(), random.normal()};
    for (int i = 0; i < times; ++i) {
      const Eigen::Vector3d move(random.normal(), random.normal(), random.normal());
      const Pose moved = translation(move_m * move) * pose;
      View view = observe({kHeldLens, world.image_size}, moved, points, exact, random);
      for (Observation& o : view.observations)
        o.pixel += options.sigma_px *
                   (std::sqrt(common) * shared[o.id] +
                    std::sqrt(1 - common) * Eigen::Vector2d(random.normal(), random.normal()));
      view.image = name + "_" + std::to_string(i);
      world.truth->camera_from_world[view.image] = moved;
      world.views.push_back(std::move(view));
    }
  }
  return world;
}

Bundle bundle_at_truth(const Dataset& world) {
  Bundle bundle;
  bundle.model = &Model::named("radial1");
  bundle.image_size = world.image_size;
  bundle.free_values = bundle.model->free_values(kHeldLens);
  for (const View& view : world.views) {
    internal::ViewProblem problem;
    problem.correspondences.own() = view_correspondences(view, world.boards).correspondences;
    bundle.views.push_back(std::move(problem));
    bundle.camera_from_target.push_back(world.truth->camera_from_world.at(view.image));
  }
  return bundle;
}

TEST(RepeatedPoses, AreViewsWhosePointsHardlyMove) {
  const std::vector<std::size_t> near = {0, 0, 0, 1, 1, 1, 2, 2, 2};
  const WorldOptions three = {.num_views = 3};
  EXPECT_EQ(internal::pose_numbers(bundle_at_truth(repeated(1, three, 3, 0.002, 0))), near);
  const auto far = internal::pose_numbers(bundle_at_truth(repeated(1, three, 3, 0.2, 0)));
  EXPECT_EQ(internal::num_poses(far), 9);
  EXPECT_EQ(internal::num_poses({}), 0);
}

// Four views of a pose whose corners share r of their noise count 4 / (1 + 3 r) times.
TEST(RepeatedPoses, TheirCorrelationShows) {
  for (const double common : {0.0, 0.3, 1.0}) {
    const Bundle bundle = bundle_at_truth(repeated(2, kEight, 4, 1e-4, common));
    const double effect = internal::design_effect(bundle, internal::pose_numbers(bundle));
    EXPECT_NEAR(effect, 1 + 3 * common, 0.25) << common;
  }
  const Bundle once = bundle_at_truth(repeated(2, kEight, 1, 0, 1));
  EXPECT_EQ(internal::design_effect(once, internal::pose_numbers(once)), 1);
}

// Copies of pictures in another compression are no further evidence; pictures with noise of their
// own are.
TEST(RepeatedPoses, CopiesDoNotNarrowAClaim) {
  CalibrateOptions options;
  options.model = "radial1";
  double of_copies = 0, of_own_noise = 0, errors = 0;
  constexpr int kSeeds = 6;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto sigma = [&](const Dataset& world) {
      const Calibration c = calibrate(world, options);
      EXPECT_EQ(c.status, Status::ok) << seed;
      errors += std::pow((parameters(c.camera->lens)[0] - 900) / c.sigmas[0], 2);
      return c.sigmas[0];
    };
    const double once = sigma(repeated(seed, kEight, 1, 0, 0.999));
    of_copies += std::log(sigma(repeated(seed, kEight, 4, 0, 0.999)) / once) / kSeeds;
    of_own_noise += std::log(sigma(repeated(seed, kEight, 4, 0, 0)) / once) / kSeeds;
  }
  EXPECT_GT(std::exp(of_copies), 0.85);
  EXPECT_LT(std::exp(of_own_noise), 0.65);
  EXPECT_LT(errors, 42.3);  // chi-square of 18: p = 0.001
}

TEST(RepeatedPoses, ManyPicturesOfOnePoseAreFew) {
  CalibrateOptions options;
  options.model = "radial1";
  const Dataset tripod = repeated(3, {.num_views = 1, .min_tilt_deg = 30}, 10, 0, 0.5);
  const Calibration c = calibrate(tripod, options);
  const auto told = std::ranges::find(c.findings, "few_views", &Finding::code);
  ASSERT_NE(told, c.findings.end());
  EXPECT_EQ(told->sentence.find("10 pictures of one pose of the board: "), 0) << told->sentence;
  const Calibration many = calibrate(repeated(3, {.num_views = 10}, 1, 0, 0), options);
  EXPECT_EQ(std::ranges::count(many.findings, "few_views", &Finding::code), 0);
  ASSERT_TRUE(many.claim.has_value());
  EXPECT_EQ(check_camera(tripod, *many.claim).verdict, CheckVerdict::cannot_tell);
}

}  // namespace
}  // namespace tagcal
