// Pictures of 16 bits a pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

Image16 read_16(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const auto decoder = png_decoder(bytes);
  EXPECT_TRUE(decoder->header().sixteen_bit);
  Image16 image({decoder->header().width, decoder->header().height});
  decoder->decode(
      [&](int y, const std::uint16_t* row) { std::copy_n(row, image.width(), image.row(y)); });
  return image;
}

// (That the decoder reads libpng's 16-bit files is for image_file_test to see.)
TEST(RenderDepth, APngKeepsSixteenBitsToTheLast) {
  const fs::path file = fs::temp_directory_path() / "tagcal_render_depth.png";
  Image16 image({300, 256});
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 300; ++x) image(x, y) = static_cast<std::uint16_t>(256 * y + x % 256);
  write_png(file, image);
  EXPECT_EQ(read_16(file).pixels(), image.pixels());
  EXPECT_EQ(read_image_size(file), image.size());
  const Image8 as_eight = read_image(file);  // the brightest is white
  for (int y = 0; y < 256; ++y)
    EXPECT_EQ(as_eight(7, y), std::lround(static_cast<double>(image(7, y)) / 257)) << y;
  fs::remove(file);
  EXPECT_THROW(write_png(file, Image16()), Error);
  EXPECT_FALSE(fs::exists(file));
}

TEST(RenderDepth, LevelsAreRoundedAndClipped) {
  ImageF light({5, 1});
  const float levels[] = {-0.1f, 0.25f, 1.0f / 3, 0.9999f, 1.2f};
  std::copy_n(levels, 5, light.row(0));
  EXPECT_EQ(expose16(light, {}, 1).pixels(),
            (std::vector<std::uint16_t>{0, 16384, 21845, 65528, 65535}));
}

// The same noise as in the 8-bit picture of that seed, on a scale 257 times as fine.
TEST(RenderDepth, IsThe8BitPictureWithoutItsRounding) {
  Random random(5);
  ImageF light({640, 400});
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 640; ++x) light(x, y) = static_cast<float>(random.uniform(0.1, 0.9));
  Sensor sensor;
  sensor.noise_levels = 3;
  const Image8 coarse = expose(light, sensor, 7);
  const Image16 fine = expose16(light, sensor, 7);
  EXPECT_EQ(fine.pixels(), expose16(light, sensor, 7).pixels());
  EXPECT_NE(fine.pixels(), expose16(light, sensor, 8).pixels());
  double squares = 0;
  for (std::size_t i = 0; i < coarse.pixels().size(); ++i) {
    const double off = fine.pixels()[i] / 257.0 - coarse.pixels()[i];
    ASSERT_LE(std::abs(off), 0.5 + 0.5 / 257 + 1e-9) << i;
    squares += off * off;
  }
  // Mostly not a multiple of 257: what 8 bits lose is spread evenly.
  EXPECT_NEAR(squares / static_cast<double>(coarse.pixels().size()), 1.0 / 12, 0.001);
}

TEST(RenderDepth, NoiseIsAsStated) {
  const ImageF light({640, 400}, 0.5f);
  Sensor sensor;
  for (const double sigma : {0.0, 0.02, 2.0}) {
    sensor.noise_levels = sigma;
    const Image16 image = expose16(light, sensor, 7);
    double sum = 0, squares = 0;
    for (const std::uint16_t value : image.pixels()) {
      const double off = value / 257.0 - 127.5;
      sum += off;
      squares += off * off;
    }
    const double n = static_cast<double>(image.pixels().size());
    // Half a level of 16 bits is what 0.5 is rounded up by.
    EXPECT_NEAR(sum / n, sigma > 0 ? 0 : 0.5 / 257, 5 * sigma / std::sqrt(n) + 1e-12);
    const double rounding = sigma > 0 ? 1 / (12 * 257.0 * 257.0) : 0.25 / (257.0 * 257.0);
    EXPECT_NEAR(squares / n, sigma * sigma + rounding, 0.015 * sigma * sigma + 1e-12);
  }
}

}  // namespace
}  // namespace tagcal
