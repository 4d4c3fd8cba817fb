#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "calibrations.hpp"
#include "rolling_worlds.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibration/readout_rounds.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace tagcal {
namespace {

CalibrateOptions with_opencv5() {
  CalibrateOptions options;
  options.model = "opencv5";
  return options;
}

Dataset still_world(std::uint64_t seed) {
  WorldOptions options;
  options.num_views = 12;
  options.sigma_px = 0;
  return make_world(opencv5_lens(), seed, options);
}

// Each view with its own velocity, of 0.3 rad/s and m/s along each axis, read in 20 ms: a corner
// moves by 5 px.
Dataset shaken_world(std::uint64_t seed, ReadDirection direction = ReadDirection::down) {
  const Dataset still = still_world(seed);
  Random random(seed, 7);
  return rolling_world(still, random_velocities(still.views.size(), 0.3, 0.3, random), 0.02,
                       direction);
}

double focal_error_px(const Calibration& c) {
  const Lens truth = opencv5_lens();
  return std::abs(parameters(c.camera->lens)[0] - parameters(truth)[0]);
}

// The focal length's squared error over its claimed variance, whose mean is 1: chi-square over 30
// worlds is within 13.8 and 53.7 in 99 %.
TEST(RollingShutter, TheClaimCoversTheErrorUnderMotion) {
  constexpr int kCount = 30;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kCount; ++seed) {
    const Calibration c = calibrate(with_noise(shaken_world(seed), 0.2, seed), with_opencv5());
    ASSERT_EQ(c.status, Status::ok);
    EXPECT_TRUE(has(c, "rolling_shutter")) << seed;
    EXPECT_FALSE(has(c, "rows_displaced")) << seed;
    sum += std::pow(focal_error_px(c) / c.sigmas[0], 2);
  }
  EXPECT_GT(sum / kCount, 0.46);
  EXPECT_LT(sum / kCount, 1.79);
}

TEST(RollingShutter, AGlobalShutterIsNone) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Dataset still = still_world(seed);
    EXPECT_FALSE(has(calibrate(still, with_opencv5()), "rolling_shutter")) << seed;
    EXPECT_FALSE(has(calibrate(with_noise(still, 0.2, seed), with_opencv5()), "rolling_shutter"))
        << seed;
  }
}

// A lens that the model does not have leaves the same field in all views.
TEST(RollingShutter, AnErrorOfTheLensIsNone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Dataset world = with_noise(still_world(seed), 0.1, seed);
    for (View& view : world.views)
      for (Observation& o : view.observations)
        o.pixel += 0.5 * Eigen::Vector2d(std::sin(o.pixel.y() / 150), std::cos(o.pixel.x() / 150));
    EXPECT_FALSE(has(calibrate(world, with_opencv5()), "rolling_shutter")) << seed;
  }
}

// A sensor's skew is in all views.
TEST(RollingShutter, ASkewOfTheSensorIsNone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Dataset world = with_noise(still_world(seed), 0.1, seed);
    for (View& view : world.views)
      for (Observation& o : view.observations) o.pixel.x() += 0.003 * (o.pixel.y() - 400);
    EXPECT_FALSE(has(calibrate(world, with_opencv5()), "rolling_shutter")) << seed;
  }
}

// Each view has its own smooth field, which follows neither rows nor columns.
TEST(RollingShutter, AFieldOfEachViewIsNone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Dataset world = with_noise(with_fields(still_world(seed), 0.5, seed), 0.1, seed);
    EXPECT_FALSE(has(calibrate(world, with_opencv5()), "rolling_shutter")) << seed;
  }
}

// Columns that are read one after another are displaced by the column, not by the row.
TEST(RollingShutter, ColumnsAreNoRows) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Dataset world = with_noise(shaken_world(seed, ReadDirection::right), 0.2, seed);
    EXPECT_FALSE(has(calibrate(world, with_opencv5()), "rolling_shutter")) << seed;
  }
}

// From the times of a film. Without noise only the poses between pictures are not known.
TEST(RollingShutter, TheReadoutOfAnExactFilm) {
  for (const double readout_s : {0.03, -0.015, 0.0}) {
    const Film exact =
        film(1, std::abs(readout_s), readout_s < 0 ? ReadDirection::up : ReadDirection::down, 40);
    CalibrateOptions options = with_opencv5();
    options.times_s = exact.times_s;
    const Calibration c = calibrate(exact.dataset, options);
    ASSERT_TRUE(c.readout) << readout_s;
    EXPECT_NEAR(c.readout->seconds, readout_s, 2e-5);
    EXPECT_EQ(c.readout->num_views, 40);
  }
}

// Also those of views that the calibration rejected, because of their motion.
TEST(RollingShutter, CornersWithoutTheMotion) {
  constexpr double kReadout = 0.02;
  Film moving = film(1, kReadout, ReadDirection::down, 40);
  moving.dataset.views[20].observations.clear();
  moving.dataset.views[21].observations.resize(2);
  const Film still = film(1, 0, ReadDirection::down, 40);
  Calibration known;
  known.camera = moving.dataset.truth->camera;
  known.readout = Readout{.seconds = kReadout};
  for (std::size_t v = 0; v < 40; ++v)
    if (v != 10 && v != 11 && v != 20 && v != 21)
      known.views.push_back({.camera_from_world = moving.dataset.truth->camera_from_world.at(
                                 moving.dataset.views[v].image),
                             .view = v});
  const Dataset found = internal::without_motion(moving.dataset, moving.times_s, known);
  for (const std::size_t v : {20UL, 21UL})  // without a pose
    EXPECT_TRUE(found.views[v].observations.empty());
  for (const std::size_t v : {5UL, 9UL, 10UL, 11UL, 12UL}) {
    ASSERT_EQ(found.views[v].observations.size(), still.dataset.views[v].observations.size()) << v;
    double largest = 0, motion = 0;
    for (std::size_t i = 0; i < found.views[v].observations.size(); ++i) {
      const Eigen::Vector2d at = still.dataset.views[v].observations[i].pixel;
      largest = std::max(largest, (found.views[v].observations[i].pixel - at).norm());
      motion = std::max(motion, (moving.dataset.views[v].observations[i].pixel - at).norm());
    }
    // The pose of a rejected view is still moved by its rows, until the next calibration.
    EXPECT_LT(largest, (v == 10 || v == 11 ? 0.2 : 0.05) * motion) << v;
  }
}

// Squared errors over their claimed variances, of the readout and of the focal length: chi-square
// over 20 films is within 7.4 and 40 in 99 %. Correlated errors of the film's poses make it less.
TEST(RollingShutter, TheReadoutAndTheLensAreWithinTheirClaims) {
  constexpr int kCount = 20;
  double readout = 0, focal = 0;
  for (std::uint64_t seed = 1; seed <= kCount; ++seed) {
    const Film exact = film(seed, 0.03, ReadDirection::down, 40);
    CalibrateOptions options = with_opencv5();
    options.times_s = exact.times_s;
    const Calibration c = calibrate(with_noise(exact.dataset, 0.2, seed), options);
    ASSERT_TRUE(c.readout) << seed;
    EXPECT_LT(std::abs(c.readout->seconds - 0.03), 6e-4) << seed;
    EXPECT_FALSE(has(c, "readout_not_observable")) << seed;
    readout += std::pow((c.readout->seconds - 0.03) / c.readout->sigma_s, 2);
    focal += std::pow(focal_error_px(c) / c.sigmas[0], 2);
  }
  for (const double sum : {readout, focal}) {
    EXPECT_GT(sum / kCount, 0.25);
    EXPECT_LT(sum / kCount, 2);
  }
}

// A camera that runs around the board: every picture is displaced in the same way, and another
// focal length, a bent board and a moved centre explain that.
TEST(RollingShutter, TimesShowAMotionThatAllPicturesShare) {
  const Film exact = ring_film(0.02, 60);
  CalibrateOptions options = with_opencv5();
  const Dataset seen = with_noise(exact.dataset, 0.05, 1);
  const Calibration alike = calibrate(seen, options);
  ASSERT_TRUE(is_answer(alike.status));
  EXPECT_GT(focal_error_px(alike), 10 * alike.sigmas[0]);
  options.times_s = exact.times_s;
  const Calibration timed = calibrate(seen, options);
  ASSERT_TRUE(timed.readout);
  EXPECT_TRUE(timed.readout->is_seen);
  EXPECT_NEAR(timed.readout->seconds, 0.02, 4 * timed.readout->sigma_s);
  EXPECT_LT(focal_error_px(timed), 4 * timed.sigmas[0]);
}

// A readout that is not seen changes nothing.
TEST(RollingShutter, TimesOfAGlobalShutterChangeNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Film exact = film(seed, 0, ReadDirection::down, 40);
    const Dataset seen = with_noise(exact.dataset, 0.2, seed);
    CalibrateOptions options = with_opencv5();
    const Calibration alone = calibrate(seen, options);
    options.times_s = exact.times_s;
    const Calibration timed = calibrate(seen, options);
    ASSERT_TRUE(timed.readout);
    EXPECT_FALSE(timed.readout->is_seen) << seed;
    EXPECT_EQ(parameters(timed.camera->lens)[0], parameters(alone.camera->lens)[0]);
    EXPECT_EQ(timed.sigmas, alone.sigmas);
  }
}

TEST(RollingShutter, TimesMustBeThoseOfTheViews) {
  const Film exact = film(1, 0.03, ReadDirection::down, 12);
  CalibrateOptions options = with_opencv5();
  options.times_s = {1, 2, 3};
  EXPECT_THROW(calibrate(exact.dataset, options), Error);
  options.times_s.assign(12, std::nan(""));
  EXPECT_THROW(calibrate(exact.dataset, options), Error);
  options.times_s.assign(12, 1.0);  // all at one time: no velocity
  EXPECT_FALSE(calibrate(exact.dataset, options).readout);
}

// Cameras of global shutters, or on a tripod.
TEST(RollingShutter, RealSetsOfStillCamerasHaveNone) {
  const std::filesystem::path sets =
      std::filesystem::path(TAGCAL_SOURCE_DIR) / "tests/data/real_corners";
  for (const char* set : {"bouguet_left", "bouguet_right", "euroc_cam0", "opencv_left"})
    EXPECT_FALSE(has(calibrate(read_dataset(sets / set).dataset, {}), "rolling_shutter")) << set;
}

}  // namespace
}  // namespace tagcal
