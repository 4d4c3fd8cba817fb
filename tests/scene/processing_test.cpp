// What the sensor does to its pictures: mosaic, denoising, sharpening, JPEG.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "expect.hpp"
#include "jpeg_of.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr ImageSize kProcessedSize{320, 200};

// Dark up to column 159, bright from column 160 on.
ImageF step(float dark, float bright) {
  ImageF light(kProcessedSize, dark);
  for (int y = 0; y < kProcessedSize.height; ++y)
    for (int x = 160; x < kProcessedSize.width; ++x) light(x, y) = bright;
  return light;
}

// Smooth hills, edges and noise.
ImageF busy_light() {
  Random random(3);
  ImageF light = step(0.2f, 0.7f);
  for (int y = 0; y < kProcessedSize.height; ++y)
    for (int x = 0; x < kProcessedSize.width; ++x)
      light(x, y) +=
          static_cast<float>(0.1 * std::sin(0.07 * x) * std::cos(0.3 * y) + 0.02 * random.normal());
  return light;
}

// Levels of 255.
double level(const Image16& image, int x, int y) { return image(x, y) / 257.0; }

struct Statistics {
  double mean = 0, variance = 0, correlation = 0;  // the last of neighbours in a row
};

Statistics statistics_of(const Image16& image) {
  const auto n = static_cast<double>(image.pixels().size());
  Statistics s;
  for (const std::uint16_t value : image.pixels()) s.mean += value / 257.0 / n;
  double products = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double off = level(image, x, y) - s.mean;
      s.variance += off * off / n;
      if (x > 0) products += off * (level(image, x - 1, y) - s.mean) / n;
    }
  }
  s.correlation = products / s.variance;
  return s;
}

double rms_difference(const Image8& a, const Image8& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i)
    squares += std::pow(static_cast<double>(a.pixels()[i]) - b.pixels()[i], 2);
  return std::sqrt(squares / static_cast<double>(a.pixels().size()));
}

int largest_difference(const Image8& a, const Image8& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i)
    largest = std::max(largest, std::abs(a.pixels()[i] - b.pixels()[i]));
  return largest;
}

TEST(Processing, ARawMosaicHasTheGainsOfItsFiltersAndTheGammaComesLast) {
  Sensor sensor;
  sensor.mosaic = {"GRBG", {0.5, 1, 0.25}, false};
  sensor.gamma = 0.5;
  const Image16 raw = expose16(ImageF({4, 4}, 0.64f), sensor, 1);
  const double green = 255 * std::sqrt(0.64), red = 255 * std::sqrt(0.32),
               blue = 255 * std::sqrt(0.16);
  for (int y = 0; y < 4; y += 2) {
    EXPECT_NEAR(level(raw, 2, y), green, 0.01);
    EXPECT_NEAR(level(raw, 3, y), red, 0.01);
    EXPECT_NEAR(level(raw, 2, y + 1), blue, 0.01);
    EXPECT_NEAR(level(raw, 3, y + 1), green, 0.01);
  }
}

// Bilinear interpolation is exact on a ramp, whatever the gains.
TEST(Processing, DemosaicingKeepsRamps) {
  ImageF light({40, 30});
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) light(x, y) = 0.2f + 0.01f * static_cast<float>(x + y);
  const Image16 grey = expose16(light, {}, 1);
  for (const char* pattern : {"RGGB", "BGGR", "GRBG", "GBRG"}) {
    Sensor sensor;
    sensor.mosaic = {pattern, {0.5, 1, 0.7}};
    const Image16 demosaiced = expose16(light, sensor, 1);
    for (int y = 1; y < 29; ++y)
      for (int x = 1; x < 39; ++x)
        ASSERT_NEAR(grey(x, y), demosaiced(x, y), 1) << pattern << ' ' << x << ' ' << y;
  }
}

// With kernels of 1, 1/2 and 1/4, and the luma's weights, the mean of the variances at red, green
// and blue pixels is 0.273 of a pixel's.
TEST(Processing, DemosaicedNoiseIsCorrelatedAndUnbiased) {
  const ImageF light({640, 400}, 0.5f);
  Sensor sensor;
  sensor.noise_levels = 3;
  const Statistics plain = statistics_of(expose16(light, sensor, 7));
  EXPECT_NEAR(plain.correlation, 0, 0.01);
  sensor.mosaic = Mosaic();
  const Statistics demosaiced = statistics_of(expose16(light, sensor, 7));
  EXPECT_NEAR(demosaiced.mean, 127.5, 0.03);
  EXPECT_NEAR(demosaiced.variance, 0.273 * 9, 0.05);
  EXPECT_GT(demosaiced.correlation, 0.3);
  sensor.mosaic->gains = {0.5, 1, 0.7};
  const Statistics balanced = statistics_of(expose16(light, sensor, 7));
  EXPECT_NEAR(balanced.mean, 127.5, 0.03);
  EXPECT_GT(balanced.variance, demosaiced.variance);
}

TEST(Processing, DenoisingKeepsEdges) {
  Sensor sensor;
  sensor.denoise = {10, 1.2};
  const Image16 edge = expose16(step(0.2f, 0.7f), sensor, 1);
  EXPECT_NEAR(level(edge, 159, 100), 0.2 * 255, 0.01);
  EXPECT_NEAR(level(edge, 160, 100), 0.7 * 255, 0.01);
  sensor.noise_levels = 3;
  EXPECT_LT(statistics_of(expose16(ImageF(kProcessedSize, 0.5f), sensor, 1)).variance, 9 / 4.0);
  // With levels far above the noise it is a Gaussian filter, of variance 1 / (4 pi sigma^2).
  sensor.denoise->levels = 250;
  EXPECT_NEAR(statistics_of(expose16(ImageF(kProcessedSize, 0.5f), sensor, 1)).variance,
              9 / (4 * std::numbers::pi * 1.2 * 1.2), 0.03);
}

// At the pixel beside a step the Gaussian's mean has the share (1 - w) / 2 of the other side, where
// w = 1 / (sqrt(2 pi) radius) is the weight of the pixel itself.
TEST(Processing, SharpeningOvershootsAtAStepAndIsClipped) {
  Sensor sensor;
  sensor.sharpen = {0.8, 1.3};
  const Image16 edge = expose16(step(0.3f, 0.6f), sensor, 1);
  const double own = 1 / (std::sqrt(2 * std::numbers::pi) * 1.3);
  const double overshoot = 0.8 * 0.3 * 255 * (1 - own) / 2;
  EXPECT_NEAR(level(edge, 159, 100), 0.3 * 255 - overshoot, 0.1);
  EXPECT_NEAR(level(edge, 160, 100), 0.6 * 255 + overshoot, 0.1);
  EXPECT_NEAR(level(edge, 150, 0), 0.3 * 255, 0.01);
  EXPECT_NEAR(level(edge, 319, 199), 0.6 * 255, 0.01);
  const Image8 clipped = expose(step(0.05f, 0.95f), sensor, 1);
  EXPECT_EQ(clipped(159, 0), 0);
  EXPECT_EQ(clipped(160, 0), 255);
}

// The transform of libjpeg rounds to whole numbers, which moves a coefficient by a step now and
// then.
TEST(Processing, JpegLosesWhatLibjpegLoses) {
  const Image8 exact = expose(busy_light(), {}, 1);
  double before = 0;
  for (const int quality : {100, 85, 50, 30, 7}) {
    Sensor sensor;
    sensor.jpeg = quality;
    const Image8 lossy = expose(busy_light(), sensor, 1);
    const std::string bytes = jpeg_of(exact, false, quality);
    Image8 expected(kProcessedSize);
    jpeg_decoder(bytes)->decode([&](int y, const std::uint16_t* row) {
      std::transform(row, row + kProcessedSize.width, expected.row(y),
                     [](std::uint16_t value) { return static_cast<std::uint8_t>(value); });
    });
    EXPECT_LT(rms_difference(lossy, expected), 0.8) << quality;
    const double lost = rms_difference(lossy, exact);
    EXPECT_NEAR(lost, rms_difference(expected, exact), 0.05 * lost + 0.1) << quality;
    EXPECT_GT(lost, before) << quality;
    before = lost;
    EXPECT_LE(largest_difference(lossy, exact), quality == 100 ? 1 : 255);
  }
  EXPECT_GT(before, 3);
}

TEST(Processing, EqualSeedsGiveEqualBytesAndEachStepCounts) {
  const ImageF light = busy_light();
  Sensor sensor;
  sensor.noise_levels = 2;
  std::vector<Image8> pictures = {expose(light, sensor, 5)};
  const auto add = [&](const auto& change) {
    change(sensor);
    pictures.push_back(expose(light, sensor, 5));
    EXPECT_EQ(expose(light, sensor, 5).pixels(), pictures.back().pixels());
    EXPECT_NE(expose(light, sensor, 6).pixels(), pictures.back().pixels());
    EXPECT_NE(pictures[pictures.size() - 2].pixels(), pictures.back().pixels());
  };
  add([](Sensor& s) { s.mosaic = Mosaic(); });
  add([](Sensor& s) { s.denoise = Denoise(); });
  add([](Sensor& s) { s.sharpen = Sharpen(); });
  add([](Sensor& s) { s.jpeg = 60; });
}

TEST(Processing, ValuesOutOfRangeAreErrors) {
  const auto message = [](const Sensor& sensor) {
    return error_of([&] { expose(ImageF({8, 8}, 0.5f), sensor, 1); });
  };
  EXPECT_EQ(message({.mosaic = Mosaic{.pattern = "RGBG"}}),
            "mosaic: pattern: must be RGGB, BGGR, GRBG or GBRG, got RGBG");
  EXPECT_EQ(message({.mosaic = Mosaic{"RGGB", {1, 0, 1}}}),
            "mosaic: gains: must be above 0 and at most 100, got 0");
  EXPECT_EQ(message({.denoise = Denoise{0, 1}}),
            "denoise: levels: must be above 0 and at most 255, got 0");
  EXPECT_EQ(message({.sharpen = Sharpen{-0.1, 1}}),
            "sharpen: amount: must be from 0 to 10, got -0.1");
  EXPECT_EQ(message({.sharpen = Sharpen{1, std::nan("")}}),
            "sharpen: radius_px: must be above 0 and at most 10, got nan");
  EXPECT_EQ(message({.jpeg = 101}), "jpeg: must be from 1 to 100, got 101");
  Sensor sensor;
  sensor.jpeg = 90;
  EXPECT_THROW(expose16(ImageF({8, 8}, 0.5f), sensor, 1), Error);
}

TEST(Processing, NarrowImagesHaveNoNeighbours) {
  Sensor sensor;
  sensor.mosaic = Mosaic();
  sensor.denoise = Denoise();
  sensor.sharpen = Sharpen();
  sensor.jpeg = 100;
  for (const ImageSize size : {ImageSize{1, 1}, {1, 9}, {9, 2}}) {
    const Image8 image = expose(ImageF(size, 0.5f), sensor, 1);
    for (const std::uint8_t value : image.pixels()) EXPECT_NEAR(value, 128, 1);
  }
}

}  // namespace
}  // namespace tagcal
