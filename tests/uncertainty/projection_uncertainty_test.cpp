#include "tagcal/uncertainty/projection_uncertainty.hpp"

#include <gtest/gtest.h>

#include "fresh_noise.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

const ImageSize kSize{1280, 800};

TEST(SeenRegion, IsTheConvexHull) {
  const std::vector<Vector2d> square = {{100, 100}, {300, 100}, {300, 300}, {100, 300}, {200, 200}};
  const SeenRegion region(kSize, square);
  EXPECT_EQ(region.hull().size(), 4u);
  EXPECT_DOUBLE_EQ(region.share(), 200.0 * 200 / (1280 * 800));
  EXPECT_TRUE(region.contains({101, 299}));
  EXPECT_FALSE(region.contains({99, 200}));
  EXPECT_GE(region.samples().size(), 12u);
  for (const Vector2d& p : region.samples()) EXPECT_TRUE(region.contains(p));
}

TEST(SeenRegion, SaysWhatIsMissing) {
  const auto gaps = [](double left, double top, double right, double bottom) {
    const std::vector<Vector2d> box = {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
    return SeenRegion(kSize, box).gaps();
  };
  EXPECT_FALSE(gaps(10, 10, 1270, 790).has_value());
  EXPECT_EQ(gaps(10, 10, 800, 790),
            "no corners in the right third of the image: the lens is extrapolated there, so take "
            "views with the board there");
  EXPECT_EQ(gaps(500, 300, 800, 500),
            "no corners in the left third, right third, upper third and lower third of the image: "
            "the lens is extrapolated there, so take views with the board there");
  EXPECT_EQ(gaps(300, 200, 980, 600),
            "no corners in the upper left, lower left, upper right and lower right corners of the "
            "image: the lens is extrapolated there, so take views with the board there");
  const std::vector<Vector2d> cut = {{0, 0}, {1279, 0}, {1279, 200}, {300, 799}, {0, 799}};
  EXPECT_EQ(SeenRegion(kSize, cut).gaps(),
            "no corners in the lower right corner of the image: the lens is extrapolated there, so "
            "take views with the board there");
  EXPECT_EQ(SeenRegion(kSize, cut).missing_parts(), std::vector<std::string>{"lower right corner"});
  EXPECT_TRUE(SeenRegion().gaps().has_value());
}

TEST(LensDifference, AMovedCameraIsNoDifference) {
  // A longer focal length is a difference at infinity. Near by, the distance of the camera explains
  // most of it.
  const std::vector<Vector2d> samples = ImageGrid{kSize, 9, 7}.pixels();
  const Camera a{opencv5_lens(), kSize};
  const auto same = lens_difference(a, a, samples, 1.0);
  ASSERT_TRUE(same.has_value());
  EXPECT_LT(same->max_px, 1e-9);
  EXPECT_LT(same->b_from_a.translation().norm(), 1e-12);
  const Camera f900{pinhole(900, 900, 639.5, 399.5), kSize};
  const Camera f909{pinhole(909, 909, 639.5, 399.5), kSize};
  const auto far = lens_difference(f900, f909, samples, kInfinitelyFar);
  const auto near = lens_difference(f900, f909, samples, 1.0);
  ASSERT_TRUE(far && near);
  EXPECT_NEAR(far->max_px, 0.01 * std::hypot(640, 400), 0.05);
  EXPECT_NEAR(far->u_px(6, 20), 6.4, 0.01);
  EXPECT_NEAR(far->v_px(0, 10), -4, 0.01);
  EXPECT_LT(near->rms_px, 0.3 * far->rms_px);
  EXPECT_NEAR(near->b_from_a.translation().z(), 0.01, 0.003);
  EXPECT_LT(far->b_from_a.translation().norm(), 1e-12);
}

TEST(LensDifference, ShiftedCentreIsARotation) {
  const std::vector<Vector2d> samples = ImageGrid{kSize, 9, 7}.pixels();
  const Camera a{pinhole(9000, 9000, 639.5, 399.5), kSize};
  const Camera b{pinhole(9000, 9000, 649.5, 399.5), kSize};
  const auto d = lens_difference(a, b, samples, kInfinitelyFar);
  ASSERT_TRUE(d.has_value());
  EXPECT_LT(d->rms_px, 0.05);
  EXPECT_NEAR(log_rotation(d->b_from_a.rotation()).y(), -10.0 / 9000, 1e-5);
}

TEST(LensDifference, DifferentImagesAreAnError) {
  const std::vector<Vector2d> samples = ImageGrid{kSize, 9, 7}.pixels();
  EXPECT_THROW(lens_difference({opencv5_lens(), kSize}, {opencv5_lens(), {640, 400}}, samples, 1.0),
               Error);
}

TEST(LensDifference, SamplesLieWhereBothHadCorners) {
  const auto square = [](double left, double right) {
    const std::vector<Vector2d> corners = {{left, 0}, {right, 0}, {right, 700}, {left, 700}};
    return SeenRegion(kSize, corners);
  };
  const SeenRegion a = square(100, 800), b = square(400, 1200), unknown;
  const auto both = common_samples(kSize, a, b);
  EXPECT_GT(both.size(), 100u);
  for (const Vector2d& p : both) EXPECT_TRUE(a.contains(p) && b.contains(p));
  EXPECT_EQ(common_samples(kSize, unknown, b), b.samples());
  EXPECT_EQ(common_samples(kSize, a, unknown), a.samples());
  EXPECT_EQ(common_samples(kSize, unknown, unknown).size(), 33u * 21u);
}

// Lenses drawn from their covariances are consistent: scores of a standard normal variable. A lens
// of another focal length is not.
TEST(DifferenceTest, ScoresOfDrawnLensesAreNormal) {
  const std::vector<Vector2d> samples = ImageGrid{kSize, 9, 7}.pixels();
  const Model& model = Model::named("radial1");  // f, cx, cy, k1
  const std::vector<double> truth = model.free_values(Perspective({900, 900, 651, 392, -0.15}));
  const std::array<double, 4> sigma_a = {0.5, 0.8, 0.8, 0.001}, sigma_b = {0.2, 0.1, 0.3, 0.0004};
  const auto drawn = [&](const std::array<double, 4>& sigma, Random& random, double shift = 0) {
    std::vector<double> values = truth;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += sigma[i] * random.normal();
    values[0] += shift;
    const Eigen::Map<const Eigen::Vector4d> sd(sigma.data());
    return UncertainCamera{
        &model, {*model.lens(values, kSize), kSize}, sd.cwiseAbs2().asDiagonal().toDenseMatrix()};
  };
  const auto score = [&](const UncertainCamera& a, const UncertainCamera& b) {
    const auto d = lens_difference(a.camera, b.camera, samples, kInfinitelyFar);
    return difference_test(a, b, samples, d.value()).value();
  };
  Random random(7);
  constexpr int kDraws = 400;
  double sum = 0, squares = 0, ratio = 0;
  for (int i = 0; i < kDraws; ++i) {
    const UncertainCamera a = drawn(sigma_a, random), b = drawn(sigma_b, random);
    const auto d = lens_difference(a.camera, b.camera, samples, kInfinitelyFar);
    const DifferenceTest test = score(a, b);
    sum += test.in_sigmas;
    squares += test.in_sigmas * test.in_sigmas;
    ratio += d->rms_px * d->rms_px / (test.expected_px * test.expected_px);
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.15);
  EXPECT_NEAR(squares / kDraws, 1, 0.25);
  EXPECT_NEAR(ratio / kDraws, 1, 0.15);
  EXPECT_GT(score(drawn(sigma_a, random), drawn(sigma_b, random, 10)).in_sigmas, 5);
  // A principal point 9 sds off, beside a focal length that is known badly.
  const std::array<double, 4> sigma_f = {5, 0.8, 0.8, 0.001};
  UncertainCamera moved = drawn(sigma_f, random);
  std::vector<double> off = model.free_values(moved.camera.lens);
  off[2] += 10;
  moved.camera.lens = *model.lens(off, kSize);
  EXPECT_GT(score(drawn(sigma_a, random), moved).in_sigmas, 4);
  // The smallest change that it states is found 98 times of 100, less two standard deviations.
  int found = 0, alarms = 0;
  for (int i = 0; i < kDraws; ++i) {
    const UncertainCamera a = drawn(sigma_a, random), same = drawn(sigma_b, random);
    const DifferenceTest test = score(a, same);
    alarms += change_verdict(test.in_sigmas, test.smallest_px, 1) == CheckVerdict::changed;
    UncertainCamera b = same;
    std::vector<double> values = model.free_values(same.camera.lens);
    values[2] += 1;  // cy
    b.camera.lens = *model.lens(values, kSize);
    const auto unit = lens_difference(same.camera, b.camera, samples, kInfinitelyFar);
    values[2] += test.smallest_px / unit->max_px - 1;
    b.camera.lens = *model.lens(values, kSize);
    found += score(a, b).in_sigmas > 2.326;
  }
  std::printf("differences: %d alarms, %d stated changes found of %d\n", alarms, found, kDraws);
  EXPECT_LE(alarms, 0.02 * kDraws);
  EXPECT_GE(found, 0.966 * kDraws);
  EXPECT_EQ(change_verdict(2, 0.5, 1), CheckVerdict::valid);
  EXPECT_EQ(change_verdict(2, 2, 1), CheckVerdict::cannot_tell);
  EXPECT_EQ(change_verdict(3, 0.5, 1), CheckVerdict::changed);
  UncertainCamera exact = drawn({}, random);
  exact.covariance.resize(0, 0);
  EXPECT_LT(score(drawn(sigma_a, random), exact).in_sigmas, 3.5);
  EXPECT_FALSE(difference_test(exact, exact, samples, {}).has_value());
}

TEST(ProjectionUncertainty, IsThatOfSolvesWithFreshNoise) {
  WorldOptions options;
  options.num_views = 6;
  options.min_distance_m = 0.6;
  const Lens lens = Perspective({900, 900, 651, 392, -0.15});
  const Bundle exact = exact_bundle(Model::named("radial1"), lens, 4, options);
  constexpr int kSolves = 200;
  for (const double distance : {kInfinitelyFar, 1.0}) {
    const PredictedAndObserved r = fresh_noise(exact, 0.3, distance, kSolves);
    ASSERT_EQ(r.solves, kSolves);
    // One standard deviation from 200 solves is known to 5 %; tagcal-study calibration_nees has
    // more.
    EXPECT_NEAR(r.ratio(6, 10), 1, 0.2) << distance;
    for (const int row : {0, 12})
      for (const int column : {0, 20}) EXPECT_NEAR(r.ratio(row, column), 1, 0.2) << distance;
  }
}

TEST(ProjectionUncertainty, GrowsWhereNothingWasSeen) {
  // With corners in the middle only, the corners of the image are extrapolated.
  Dataset world = make_world(opencv5_lens(), 6);
  for (View& view : world.views)
    std::erase_if(view.observations,
                  [](const Observation& o) { return (o.pixel - Vector2d(640, 400)).norm() > 250; });
  CalibrateOptions options;
  options.model = "opencv5";
  const Calibration c = calibrate(world, options);
  ASSERT_EQ(c.projection.size(), 2u);
  EXPECT_EQ(c.projection[0].distance_m, kInfinitelyFar);
  EXPECT_NEAR(c.projection[1].distance_m, 1.1, 0.2);
  for (const ProjectionUncertainty& p : c.projection) {
    EXPECT_LT(p.sigma_px(6, 10), 1);
    EXPECT_FALSE(p.sigma_px(0, 0) < 20 * p.sigma_px(6, 10));  // or has no value
  }
  EXPECT_FALSE(c.findings.empty());
}

}  // namespace
}  // namespace tagcal
