#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>

#include "corner_tally.hpp"
#include "rendered_tag.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

const ImageSize kPicture{1280, 800};
const Camera kBarrel = {Perspective({900, 900, 652, 391, -0.25}), kPicture};
const Camera kStrongBarrel = {Perspective({900, 900, 652, 391, -0.4}), kPicture};
const Camera kFisheyeCamera = {Fisheye({400, 400, 652, 391, -0.02, 0.004, -0.002, 0}), kPicture};

enum class LensIs { unknown, known };

// Anywhere in the picture, to its border.
Trials lens_trials(const Camera& camera, double side_px, LensIs lens, double blur_px = 0.8,
                   double noise = 2) {
  constexpr int kCount = 16;
  Random random(41);
  const TagFamily family = tag_family("tag36h11", 1);
  Tally tally;
  for (int i = 0; i < kCount; ++i) {
    const TagViewSpec spec{side_px, random.uniform(0, 50), blur_px, noise};
    const TagView view = tag_through_lens(spec, camera, random);
    TagFitOptions options;
    if (lens == LensIs::known) options.camera = &view.camera;
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    tally.add(refine_tag(view.image, pattern, moved(view.corners, 0.3, random), options),
              view.corners);
  }
  return tally.result();
}

TEST(RefineTagLens, NotKnown) {
  for (const auto& [camera, side_px] : {std::pair{&kBarrel, 30.0},
                                        {&kBarrel, 90.0},
                                        {&kBarrel, 200.0},
                                        {&kFisheyeCamera, 50.0},
                                        {&kFisheyeCamera, 200.0}}) {
    const Trials t = lens_trials(*camera, side_px, LensIs::unknown);
    EXPECT_LE(t.failed, 1) << side_px;
    EXPECT_NEAR(t.nees, 1, 0.4) << side_px;  // three sds of the mean over so few
    EXPECT_LT(t.rms, 0.02) << side_px;
  }
}

// A large tag is fitted corner by corner: what is said of the whole is that of its parts.
TEST(RefineTagLens, TheNoiseOfALargeTagIsThatOfThePicture) {
  Random random(43);
  const TagFamily family = tag_family("tag36h11", 1);
  for (const double noise : {1.0, 4.0}) {
    const TagView view = tag_through_lens({200, 20, 0.8, noise}, kBarrel, random);
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    const TagFit fit = refine_tag(view.image, pattern, view.corners);
    // A large tag is fitted corner by corner at once, with all of its pixels, whatever follows.
    EXPECT_EQ(refine_tag(view.image, pattern, view.corners, {.lens_follows = true}).covariance_px2,
              fit.covariance_px2);
    ASSERT_EQ(fit.status, TagFitStatus::converged);
    EXPECT_TRUE(fit.is_by_corner);
    EXPECT_NEAR(fit.noise_levels, noise, 0.15 * noise);
    EXPECT_NEAR(fit.blur_px, 0.8, 0.1);
    EXPECT_NEAR(fit.black, 30, 5);
    EXPECT_NEAR(fit.white, 220, 5);
  }
}

// Bounds are 1.3 times that of the straight model at 30 deg.
TEST(RefineTagLens, Known) {
  for (const auto& [camera, side_px, rms_px] : {std::tuple{&kBarrel, 40.0, 0.0066},
                                                {&kStrongBarrel, 150.0, 0.0031},
                                                {&kFisheyeCamera, 40.0, 0.0066},
                                                {&kFisheyeCamera, 150.0, 0.0031}}) {
    const Trials t = lens_trials(*camera, side_px, LensIs::known);
    EXPECT_EQ(t.failed, 0) << side_px;
    EXPECT_NEAR(t.nees, 1, 0.4) << side_px;
    EXPECT_LT(t.rms, rms_px) << side_px;
    EXPECT_LT(t.mean.cwiseAbs().maxCoeff(), 0.002) << side_px;
    EXPECT_LT(std::abs(t.outwards), 0.002) << side_px;
  }
}

// Far from the middle of a wide picture lines cross at other angles than before the lens.
TEST(RefineTagLens, KnownAndBlurredWithLittleNoise) {
  const Camera wide = {pinhole(300, 300, 652, 391), kPicture};
  const Trials t = lens_trials(wide, 60, LensIs::known, 1.5, 0.3);
  EXPECT_EQ(t.failed, 0);
  EXPECT_LT(t.rms, 0.0019);  // 0.0021 with the angle before the lens; the noise allows 0.0012
}

TEST(RefineTagLens, CameraOfAnotherPicture) {
  const Image8 flat({100, 100}, 128);
  TagFitOptions options;
  options.camera = &kBarrel;
  const Corners corners = {Eigen::Vector2d(20, 80), {80, 80}, {80, 20}, {20, 20}};
  EXPECT_THROW(refine_tag(flat, tag_pattern(tag_family("tag36h11", 1), 0, 1), corners, options),
               Error);
}

}  // namespace
}  // namespace tagcal
