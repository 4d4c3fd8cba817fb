// Pictures that their camera has sharpened: the sharpening is found and undone, so that corners are
// as exact as without it, and as exact as they claim.

#include <gtest/gtest.h>

#include <cmath>

#include "corner_tally.hpp"
#include "rendered_tag.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/picture_processing.hpp"
#include "tagcal/detect/tag_fit/sharpening.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr int kWidth = 140;

// Tags of 45 px, tilted by up to 60 degrees.
class SharpTags {
 public:
  SharpTags(const Sharpen& sharpen, double ink, double paper) : ink_(ink), paper_(paper) {
    if (sharpen.amount > 0) sharpen_ = sharpen;
  }

  TagView next() {
    TagScene tag({kSide, random_.uniform(0, 60), 0.8, 2}, random_);
    tag.scene.camera = {pinhole(900, 900, kMiddle, kMiddle), {kWidth, kWidth}};
    tag.scene.paper_level = paper_ / 255;
    tag.scene.ink_level = ink_ / 255;
    tag.scene.sensor.sharpen = sharpen_;
    const Pose pose = tag_pose(Eigen::Vector3d::UnitZ(), 900 / kSide, random_.uniform(0, 60),
                               random_turns(random_));
    return tag.view(pose, random_);
  }

  Random& random() { return random_; }

 private:
  static constexpr double kSide = 45, kMiddle = 69.3;
  double ink_, paper_;
  std::optional<Sharpen> sharpen_;
  Random random_{78};
};

struct SharpTrials {
  Trials corners;
  double amount = 0, radius_px = 0;  // means
  int num_gammas = 0;                // tags whose gamma is not 1
};

// Fits with a given sharpening, or with the processing that each picture shows.
SharpTrials trials(SharpTags tags, const std::optional<Sharpen>& given = {}) {
  constexpr int kCount = 30;
  const TagFamily family = tag_family("tag36h11", 1);
  Tally tally;
  SharpTrials result;
  for (int i = 0; i < kCount; ++i) {
    const TagView view = tags.next();
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    const Corners start = moved(view.corners, 0.2, tags.random());
    TagFitOptions options;
    options.bend_sd_per_px = 0;
    options.shift_sd_px = 0.1;
    if (given) {
      options.processing.sharpen = *given;
    } else {
      const CameraProcessing found = processing_of_picture(view.image, {{&pattern, start}});
      options.processing = found;
      result.amount += found.sharpen.amount / kCount;
      result.radius_px += found.sharpen.radius_px / kCount;
      result.num_gammas += found.gamma != 1;
    }
    tally.add(refine_tag(view.image, pattern, start, options), view.corners);
  }
  result.corners = tally.result();
  return result;
}

void expect_as_exact(const SharpTrials& t, const Trials& plain, const Sharpen& sharpen) {
  const auto name = ::testing::Message() << sharpen.amount << ' ' << sharpen.radius_px;
  EXPECT_EQ(t.corners.failed, 0) << name;
  EXPECT_EQ(t.num_gammas, 0) << name;
  EXPECT_NEAR(t.amount, sharpen.amount, 0.2 * sharpen.amount) << name;
  EXPECT_NEAR(t.radius_px, sharpen.radius_px, 0.1) << name;
  EXPECT_LT(t.corners.rms, 1.06 * plain.rms) << name;
  EXPECT_NEAR(t.corners.nees, plain.nees, 0.1) << name;
}

TEST(Sharpening, CornersAreAsExactAsWithout) {
  const Trials plain = trials({{0, 1}, 30, 220}).corners;
  EXPECT_NEAR(plain.nees, 1, 0.15);
  for (const Sharpen sharpen : {Sharpen{0.3, 1.3}, {0.6, 0.7}, {0.6, 2}, {1, 0.7}, {1, 1.3}})
    expect_as_exact(trials({sharpen, 30, 220}), plain, sharpen);
  EXPECT_GT(trials({{0.6, 2}, 30, 220}, Sharpen{0, 1}).corners.rms, 5 * plain.rms);
}

TEST(Sharpening, CornersOfLittleContrastAreAsExactAsWithout) {
  const Trials plain = trials({{0, 1}, 90, 160}).corners;
  for (const Sharpen sharpen : {Sharpen{0.6, 0.7}, {0.6, 2}, {1, 1.3}})
    expect_as_exact(trials({sharpen, 90, 160}), plain, sharpen);
}

// The brightest and the darkest overshoot is cut off.
TEST(Sharpening, OvershootMayBeClipped) {
  const double rms = trials({{0, 1}, 30, 220}).corners.rms;
  const Sharpen sharpen{1, 2};
  const Trials known = trials({sharpen, 30, 220}, sharpen).corners;
  EXPECT_LT(known.rms, 1.15 * rms);
  EXPECT_LT(known.nees, 1.2);
  const Trials found = trials({sharpen, 30, 220}).corners;
  EXPECT_LT(found.rms, 1.25 * rms);
  EXPECT_LT(found.nees, 1.4);
}

TEST(Sharpening, APlainPictureHasNone) {
  SharpTags tags({0, 1}, 30, 220);
  const TagFamily family = tag_family("tag36h11", 1);
  for (int i = 0; i < 30; ++i) {
    const TagView view = tags.next();
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    EXPECT_TRUE(processing_of_picture(view.image, {{&pattern, view.corners}}).is_none()) << i;
  }
}

// A picture of 16 bits, sharpened as the renderer does it, up to its edge.
TEST(Sharpening, IsUndone) {
  SharpTags tags({0, 1}, 30, 220);
  const TagView view = tags.next();
  Sensor sensor;
  sensor.bits = 16;
  ImageF light({kWidth, kWidth});
  for (int y = 0; y < kWidth; ++y)
    for (int x = 0; x < kWidth; ++x) light(x, y) = static_cast<float>(view.image(x, y)) / 255;
  const Image16 plain = expose16(light, sensor, 1);
  for (const Sharpen sharpen : {Sharpen{0.2, 3}, {0.4, 0.5}, {0.4, 1.3}}) {
    sensor.sharpen = sharpen;
    const Image16 sharp = expose16(light, sensor, 1);
    const PixelBox part{0, 30, {100, 80}};
    const UnsharpenedPart undone(ImageView16(sharp), part, sharpen);
    const std::vector<float> levels = undone.levels();
    for (int y = 0; y < part.size.height; ++y)
      for (int x = 0; x < part.size.width; ++x)
        ASSERT_NEAR(levels[static_cast<std::size_t>(y * part.size.width + x)],
                    plain(part.left + x, part.top + y), 30)
            << x << ' ' << y;
  }
}

// The first order in the amount: a mean of 1 over all frequencies, less the mean's own weight.
TEST(Sharpening, MeanLogGain) {
  constexpr double kAmount = 1e-4;
  for (const double radius_px : {0.5, 1.0, 2.5}) {
    double sum = 0;
    for (int i = -9; i <= 9; ++i) sum += std::exp(-i * i / (2 * radius_px * radius_px));
    EXPECT_NEAR(mean_log_gain({kAmount, radius_px}) / kAmount, 1 - 1 / (sum * sum), 1e-3);
  }
  EXPECT_EQ(mean_log_gain({0, 1}), 0);
}

}  // namespace
}  // namespace tagcal
