#include "tagcal/io/image_file.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdio>

#include "file_fixture.hpp"
#include "jpeg_of.hpp"
#include "png_colours.hpp"

namespace tagcal {
namespace {

class ImageFile : public FileTest {
 protected:
  fs::path put(const std::string& bytes) const { return write("picture", bytes); }
};

struct Format {
  int colour = PNG_COLOR_TYPE_GRAY;
  int bits = 8;
  int interlace = PNG_INTERLACE_NONE;
  int filters = PNG_ALL_FILTERS;
};

// Encodes 16-bit values by libpng, the same in all colour channels, with half-transparent alpha.
std::string png_of(const std::vector<std::uint16_t>& values, int width, const Format& format) {
  const int height = static_cast<int>(values.size()) / width;
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, size_t count) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               format.bits, format.colour, format.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_DEFAULT, format.filters);
  std::vector<png_color> palette(256);
  for (int i = 0; i < 256; ++i) {
    const auto level = static_cast<png_byte>(255 - i);
    palette[static_cast<std::size_t>(i)] = {level, level, level};
  }
  const bool indexed = format.colour == PNG_COLOR_TYPE_PALETTE;
  if (indexed) png_set_PLTE(png, info, palette.data(), 256);
  png_write_info(png, info);
  const int channels = png_get_channels(png, info);
  const bool alpha = (format.colour & PNG_COLOR_MASK_ALPHA) != 0;
  std::vector<std::vector<png_byte>> rows(static_cast<std::size_t>(height));
  std::vector<png_bytep> pointers;
  for (int y = 0; y < height; ++y) {
    auto& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < channels; ++c) {
        int value = values[static_cast<std::size_t>(y * width + x)];
        if (alpha && c == channels - 1) value = format.bits == 16 ? 0x8000 : 0x80;
        if (indexed) value = 255 - value;
        if (format.bits == 16) row.push_back(static_cast<png_byte>(value >> 8));
        row.push_back(static_cast<png_byte>(value & 255));
      }
    }
    pointers.push_back(row.data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

Image8 test_picture(int width, int height) {
  Image8 image({width, height});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = static_cast<std::uint8_t>(128 + 100 * std::sin(0.2 * x) * std::cos(0.15 * y));
    }
  }
  return image;
}

std::vector<std::uint16_t> values_of(const Image8& image, int scale) {
  std::vector<std::uint16_t> values;
  for (const int value : image.pixels()) {
    values.push_back(static_cast<std::uint16_t>(value * scale));
  }
  return values;
}

std::string error_of_file(const fs::path& file) {
  return error_of([&] { read_image(file); });
}

TEST_F(ImageFile, WhatIsWrittenIsRead) {
  Random random(3);
  Image8 image({37, 23});
  for (int y = 0; y < 23; ++y) {
    for (int x = 0; x < 37; ++x) image(x, y) = static_cast<std::uint8_t>(random.index(256));
  }
  write_png(folder_ / "a.png", image);
  const Image8 again = read_image(folder_ / "a.png");
  EXPECT_EQ(again.size(), image.size());
  EXPECT_EQ(again.pixels(), image.pixels());
  EXPECT_EQ(read_image_size(folder_ / "a.png"), image.size());
  write_png(folder_ / "b.png", image);
  EXPECT_EQ(read_text(folder_ / "a.png"), read_text(folder_ / "b.png"));
}

TEST_F(ImageFile, ColourIsWritten) {
  Random random(4);
  ImageRgb image({37, 23});
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 37; ++x)
      for (std::uint8_t& value : image(x, y)) value = static_cast<std::uint8_t>(random.index(256));
  write_png(folder_ / "colour.png", image);
  EXPECT_EQ(read_image_size(folder_ / "colour.png"), image.size());
  EXPECT_EQ(png_colours(folder_ / "colour.png"), image.pixels());
  EXPECT_THROW(write_png(folder_ / "none.png", ImageRgb()), Error);
  EXPECT_FALSE(fs::exists(folder_ / "none.png"));
}

TEST_F(ImageFile, EveryKindOfPngGivesTheSameGrey) {
  const Image8 image = test_picture(33, 21);
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    for (const int colour : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_GRAY_ALPHA,
                             PNG_COLOR_TYPE_RGB_ALPHA, PNG_COLOR_TYPE_PALETTE}) {
      const fs::path file = put(png_of(values_of(image, 1), 33, {colour, 8, interlace}));
      EXPECT_EQ(read_image(file).pixels(), image.pixels()) << colour << " " << interlace;
    }
  }
}

TEST_F(ImageFile, EveryFilterOfPngGivesTheSameGrey) {
  Image8 image = test_picture(33, 21);
  image(5, 5) = 255;  // 16 bits are scaled to the brightest
  for (const int filter :
       {PNG_FILTER_NONE, PNG_FILTER_SUB, PNG_FILTER_UP, PNG_FILTER_AVG, PNG_FILTER_PAETH}) {
    for (const int bits : {8, 16}) {
      for (const int colour : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB}) {
        const Format format{colour, bits, PNG_INTERLACE_NONE, filter};
        const fs::path file = put(png_of(values_of(image, bits == 8 ? 1 : 257), 33, format));
        EXPECT_EQ(read_image(file).pixels(), image.pixels()) << filter << " " << colour;
      }
    }
  }
}

TEST_F(ImageFile, SixteenBitsAreScaledToTheBrightest) {
  Image8 image = test_picture(33, 21);
  image(5, 5) = 255;
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    for (const int colour : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_GRAY_ALPHA,
                             PNG_COLOR_TYPE_RGB_ALPHA}) {
      for (const int scale : {257, 16, 1}) {  // full range, 12-bit and 8-bit data
        const fs::path file = put(png_of(values_of(image, scale), 33, {colour, 16, interlace}));
        EXPECT_EQ(read_image(file).pixels(), image.pixels()) << colour << " " << scale;
      }
    }
  }
  const fs::path black = put(png_of(std::vector<std::uint16_t>(100, 0), 10, {0, 16, 0}));
  EXPECT_EQ(read_image(black).pixels(), std::vector<std::uint8_t>(100, 0));
}

TEST_F(ImageFile, SixteenBitsInMemoryAreScaledAsThoseOfAFile) {
  const Image8 image = test_picture(33, 21);
  const std::vector<std::uint16_t> values = values_of(image, 16);
  const Image8 read = read_image(put(png_of(values, 33, {PNG_COLOR_TYPE_GRAY, 16, 0})));
  std::vector<std::uint16_t> wide;  // each row with 7 values after it
  for (std::size_t i = 0; i < values.size(); ++i) {
    wide.push_back(values[i]);
    if (i % 33 == 32) wide.insert(wide.end(), 7, 65535);
  }
  EXPECT_EQ(scaled_to_8_bits({wide.data(), {33, 21}, 40}).pixels(), read.pixels());
}

// 12-bit values of a dark picture, in a file of 16 bits, with a few hot pixels.
TEST_F(ImageFile, HotPixelsDoNotLeaveTheRestInTheDark) {
  std::vector<std::uint16_t> values;
  for (int i = 0; i < 10000; ++i) values.push_back(static_cast<std::uint16_t>(i % 100));
  for (const std::size_t hot : {17U, 4000U, 9000U}) values[hot] = 4095;
  const Image8 image = read_image(put(png_of(values, 100, {PNG_COLOR_TYPE_GRAY, 16, 0})));
  EXPECT_EQ(image.pixels()[17], 255);
  EXPECT_EQ(image.pixels()[99], 128);  // half of the range at least
  EXPECT_EQ(image.pixels()[100], 0);
  // A lamp in the picture that fills more than a thousandth is part of it.
  for (std::size_t i = 0; i < 50; ++i) values[i] = 4095;
  const Image8 lamp = read_image(put(png_of(values, 100, {PNG_COLOR_TYPE_GRAY, 16, 0})));
  EXPECT_EQ(lamp.pixels()[99], 6);
}

TEST_F(ImageFile, ColourIsWeighedByRec601) {
  write_png(folder_ / "rgb.png", [] {
    ImageRgb image({3, 1});
    image(0, 0) = {255, 0, 0};
    image(1, 0) = {0, 255, 0};
    image(2, 0) = {0, 0, 255};
    return image;
  }());
  EXPECT_EQ(read_image(folder_ / "rgb.png").pixels(), (std::vector<std::uint8_t>{76, 150, 29}));
}

TEST_F(ImageFile, JpegGreyAndColour) {
  const Image8 image = test_picture(50, 40);
  for (const bool colour : {false, true}) {
    const fs::path file = put(jpeg_of(image, colour));
    EXPECT_EQ(read_image_size(file), image.size());
    const Image8 read = read_image(file);
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      EXPECT_NEAR(read.pixels()[i], image.pixels()[i], 3);
    }
  }
}

TEST_F(ImageFile, Pgm) {
  using std::string_literals::operator""s;
  const std::vector<std::uint8_t> expected{0, 127, 255, 1, 2, 3};
  EXPECT_EQ(read_image(put("P2\n# a comment\n3 2 # 3 wide\n255\n0 127 255\n1 2 3\n")).pixels(),
            expected);
  EXPECT_EQ(read_image(put("P5 3 2 255\n\x00\x7f\xff\x01\x02\x03"s)).pixels(), expected);
  EXPECT_EQ(read_image(put("P5 3 1 4095\n\x00\x00\x07\xff\x0f\xff"s)).pixels(),
            (std::vector<std::uint8_t>{0, 127, 255}));
  EXPECT_EQ(read_image(put("P2 3 1 4095 0 2047 4095")).pixels(),
            (std::vector<std::uint8_t>{0, 127, 255}));
  EXPECT_EQ(read_image(put("P2 3 1 15 0 1 15")).pixels(), (std::vector<std::uint8_t>{0, 17, 255}));
  EXPECT_EQ(read_image_size(put("P5 3 2 255\n\x00\x7f\xff\x01\x02\x03"s)), (ImageSize{3, 2}));
  for (const std::string& bad :
       {"P5"s, "P5 3"s, "P5 3 2 255\n12345"s, "P2 3 1 255 1 2"s, "P2 2 1 7 1 8"s, "P5 0 3 255\n"s,
        "P5 3 -1 255\n"s, "P5 1 1 0\n1"s, "P5 1 1 70000\n11"s, "P5 x y 255\n"s,
        "P5 99999999999999 2 255\n"s}) {
    EXPECT_NE(error_of_file(put(bad)), "no error") << bad;
  }
}

TEST_F(ImageFile, TooLargeIsRefusedBeforeItIsAllocated) {
  std::string png = png_of({1, 2, 3, 4}, 2, {});
  png.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8));  // the checksum is wrong
  EXPECT_NE(error_of_file(put(png)), "no error");
  const std::string message = error_of_file(put("P5 10001 10000 255\n"));
  EXPECT_HAS(message, "at most 100000000 pixels, got 10001x10000");
  std::string jpeg = jpeg_of(test_picture(16, 16), false);
  const std::size_t frame = jpeg.find("\xff\xc0");
  jpeg.replace(frame + 5, 4, "\xf0\xf0\xf0\xf0");
  EXPECT_HAS(error_of_file(put(jpeg)), "at most 100000000 pixels");
}

TEST_F(ImageFile, CutAnywhereIsAnError) {
  const Image8 image = test_picture(40, 30);
  for (const std::string& whole :
       {png_of(values_of(image, 1), 40, {}), png_of(values_of(image, 1), 40, {2, 8, 1}),
        jpeg_of(image, false), jpeg_of(image, true)}) {
    ASSERT_EQ(error_of_file(put(whole)), "no error");
    for (std::size_t length = 0; length < whole.size();
         length += length < 100 || length + 50 > whole.size() ? 1 : 7) {
      const fs::path file = put(whole.substr(0, length));
      const std::string message = error_of_file(file);
      ASSERT_TRUE(message.starts_with(file.string() + ": ")) << length << " of " << whole.size();
      ASSERT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST_F(ImageFile, DamageNeverCrashes) {
  Random random(11);
  const Image8 image = test_picture(40, 30);
  int errors = 0;
  for (const std::string& whole : {png_of(values_of(image, 1), 40, {}), jpeg_of(image, true),
                                   std::string("P2 3 2 255 0 127 255 1 2 3")}) {
    for (int trial = 0; trial < 100; ++trial) {
      std::string damaged = whole;
      for (int i = 0; i < 3; ++i) {
        damaged[random.index(damaged.size())] = static_cast<char>(random.index(256));
      }
      errors += error_of_file(put(damaged)) == "no error" ? 0 : 1;
    }
  }
  EXPECT_GT(errors, 100);
}

TEST_F(ImageFile, WhatIsNoPictureIsNamed) {
  EXPECT_EQ(error_of_file(folder_ / "none.png"),
            (folder_ / "none.png").string() + ": no such file");
  EXPECT_HAS(error_of_file(folder_), "folder");
  EXPECT_HAS(error_of_file(put("")), "is empty");
  EXPECT_HAS(error_of_file(put("hello, I am a text")),
             "is not a PNG, JPEG, TIFF, BMP, WebP, HEIC, PGM or PPM");
  EXPECT_THROW(write_png(folder_ / "no_such_folder" / "a.png", test_picture(8, 8)), Error);
  EXPECT_THROW(write_png(folder_ / "a.png", Image8()), Error);
  EXPECT_FALSE(fs::exists(folder_ / "a.png"));
}

}  // namespace
}  // namespace tagcal
