#include "tagcal/detect/tag_fit/image_filters.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "study/chart/corner_methods.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
using namespace study;
using namespace internal;
namespace {

Image8 ramp(int width, int height, int across, int down) {
  Image8 image({width, height});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.row(y)[x] = static_cast<std::uint8_t>(20 + across * x + down * y);
  return image;
}

// Cubic convolution has straight lines as they are; new pixels lie at x / 2 - 1 / 4.
TEST(ImageFilters, DoublingKeepsARampWhereItWas) {
  const Image8 image = ramp(12, 9, 8, 4), twice = doubled(image);
  ASSERT_EQ(twice.width(), 24);
  ASSERT_EQ(twice.height(), 18);
  for (int y = 4; y < 14; ++y)
    for (int x = 4; x < 20; ++x)
      EXPECT_EQ(twice.row(y)[x], 20 + 8 * (0.5 * x - 0.25) + 4 * (0.5 * y - 0.25)) << x << ' ' << y;
}

// A tenth of the differences are of structure, which moves the quantile by 12 %; rounding adds 4 %
// to the least noise.
TEST(ImageFilters, NoiseIsMeasuredBesideStructure) {
  Random random(3);
  for (const double sigma : {1.0, 4.0, 12.0}) {
    Image8 image({320, 200});
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 320; ++x)
        image.row(y)[x] = static_cast<std::uint8_t>(
            std::lround((x / 20 + y / 20) % 2 * 100 + 70 + x / 16 + sigma * random.normal()));
    EXPECT_NEAR(noise_of(image), sigma, 0.2 * sigma);
  }
  EXPECT_LT(noise_of(ramp(16, 12, 8, 4)), 0.2);
}

TEST(ImageFilters, DoublingStaysInRangeAndHalvingUndoesIt) {
  Image8 image({7, 5});
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) image.row(y)[x] = (x + y) % 3 == 0 ? 255 : 0;
  const Image8 twice = doubled(image);
  int most = 0, least = 255;
  for (int y = 0; y < twice.height(); ++y)
    for (int x = 0; x < twice.width(); ++x)
      most = std::max<int>(most, twice.row(y)[x]), least = std::min<int>(least, twice.row(y)[x]);
  EXPECT_EQ(most, 255);
  EXPECT_EQ(least, 0);
  const Image8 flat = doubled(ramp(8, 8, 0, 0));
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) EXPECT_EQ(flat.row(y)[x], 20);
  const Image8 back = halved(doubled(ramp(12, 12, 8, 4)));
  for (int y = 2; y < 10; ++y)
    for (int x = 2; x < 10; ++x) EXPECT_EQ(back.row(y)[x], 20 + 8 * x + 4 * y);
}

// Squares of a few pixels, turned, in noise, and the same behind the filters of a sensor.
TEST(ImageFilters, OnlyAMosaicOfSmallPicturesIsOne) {
  Random random(5);
  int mosaics = 0, named = 0;
  for (int i = 0; i < 400; ++i) {
    const auto width = static_cast<int>(random.uniform(8, 64));
    const auto height = static_cast<int>(random.uniform(8, 48));
    const double side = random.uniform(3, 8), turn = random.uniform(0, 1);
    Image8 image({width, height}), raw({width, height});
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double u = (x + turn * y) / side, v = (y - turn * x) / side;
        const bool is_white = (std::lround(u) + std::lround(v)) % 2 == 0;
        const double level = (is_white ? 180 : 60) + 3 * random.normal();
        image.row(y)[x] = static_cast<std::uint8_t>(std::lround(level));
        raw.row(y)[x] =
            static_cast<std::uint8_t>(std::lround((x + y) % 2 == 0 ? level : 0.6 * level));
      }
    if (PictureToSearch(image).gain > 1) ++named;
    if (width >= 32 && height >= 32 && side > 4) {
      ++mosaics;
      EXPECT_NEAR(PictureToSearch(raw).gain, 1 / 0.6, 0.1) << width << 'x' << height;
    }
  }
  EXPECT_LE(named, 4);
  EXPECT_GT(mosaics, 30);
}

// Of 12 px and 15 px AprilTag sees few, in a doubled picture most.
TEST(ImageFilters, TagsAreReadDownToTwelvePixels) {
  for (const double side : {12.0, 15.0}) {
    TagViewSpec spec;
    spec.side_px = side;
    spec.tilt_deg = 20;
    spec.blur_px = 0.5;
    int found = 0, near = 0;
    for (std::uint64_t seed = 0; seed < 15; ++seed) {
      Random random(seed);
      const CornerTask task = draw_corner_task(spec, random);
      const View view = detect(task.view.image, {task.board}, {.threads = 1}).view;
      if (view.observations.size() != 4) continue;
      ++found;
      double largest = 0;
      for (std::size_t i = 0; i < 4; ++i)
        largest = std::max(largest, (view.observations[i].pixel - task.view.corners[i]).norm());
      near += largest < 0.5;
    }
    EXPECT_GE(found, 14) << side;
    EXPECT_EQ(near, found) << side;
  }
}

}  // namespace
}  // namespace tagcal
