// TIFF, BMP and WebP, of the kinds that other programs write; damaged and truncated files.
#include <fmt/format.h>

#include <cstring>

#include "jpeg_of.hpp"
#include "picture_bytes.hpp"

namespace tagcal {
namespace {

using std::string_literals::operator""s;

std::string fmt(int value) { return std::to_string(value); }

class PictureFormats : public FileTest {
 protected:
  // Reads the file, compares its values with the first samples of each pixel.
  void expect_tiff(const TiffKind& k, const std::string& what, int tolerance = 0) const {
    const auto values = smooth_values(kSize, k.samples, k.bits == 16 ? 200 : 1);
    tiff_of(folder_ / "a.tif", kSize, values, k);
    const Picture read = read_picture(folder_ / "a.tif");
    const int channels = k.samples >= 3 ? 3 : 1;
    ASSERT_EQ(read.index(), (channels == 3 ? 2U : 0U) + (k.bits == 16 ? 1U : 0U)) << what;
    ASSERT_EQ(size_of(read), kSize) << what;
    EXPECT_EQ(read_image_size(folder_ / "a.tif"), kSize);
    const std::vector<int> got = values_of(read);
    for (std::size_t i = 0; i < got.size(); ++i) {
      const std::size_t at =
          i / static_cast<std::size_t>(channels) * static_cast<std::size_t>(k.samples) +
          i % static_cast<std::size_t>(channels);
      const int expected = k.photometric == PHOTOMETRIC_MINISWHITE ? 255 - values[at] : values[at];
      ASSERT_NEAR(got[i], expected, tolerance) << what << " value " << i;
    }
  }

  std::string error_of_file(const std::string& bytes) const {
    const fs::path file = write("picture", bytes);
    return error_of([&] { read_picture(file); });
  }

  static constexpr ImageSize kSize{37, 23};
};

TEST_F(PictureFormats, TiffsOfAllLayouts) {
  for (const int compression :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS})
    for (const bool tiled : {false, true})
      for (const int bits : {8, 16})
        for (const int samples : {1, 2, 3, 4})  // with and without alpha
          for (const bool separate : {false, true}) {
            const int photometric = samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
            expect_tiff({bits, samples, photometric, compression, tiled, separate},
                        fmt(compression) + (tiled ? " tiles " : " strips ") + fmt(bits) + " bits " +
                            fmt(samples) + (separate ? " separate" : ""));
          }
}

TEST_F(PictureFormats, TiffsOfOtherKinds) {
  TiffKind k;
  k.mode = "wb";  // big-endian
  k.bits = 16;
  expect_tiff(k, "big-endian");
  k.mode = "w8";
  expect_tiff(k, "BigTIFF");
  k = {};
  k.photometric = PHOTOMETRIC_MINISWHITE;
  expect_tiff(k, "white is zero");
  k = {};
  k.compression = COMPRESSION_JPEG;
  k.tiled = true;
  expect_tiff(k, "JPEG", 3);
  k.samples = 3;
  k.photometric = PHOTOMETRIC_YCBCR;
  expect_tiff(k, "JPEG in colour", 60);  // of halved resolution
  k = {};
  k.bits = 4;
  const auto few = tiff_of(folder_ / "four.tif", {3, 2}, {0x0f, 0x70, 0x12, 0x30}, k);
  EXPECT_EQ(values_of(read_picture(folder_ / "four.tif")),
            (std::vector<int>{0, 255, 119, 17, 34, 51}));
  k = {};
  k.photometric = PHOTOMETRIC_PALETTE;
  tiff_of(folder_ / "palette.tif", {2, 1}, {0, 5}, k);
  EXPECT_EQ(values_of(read_picture(folder_ / "palette.tif")),
            (std::vector<int>{0, 255, 255, 250, 250, 250}));
  k = {};
  k.orientation = 6;
  tiff_of(folder_ / "turned.tif", {2, 1}, {1, 2}, k);
  EXPECT_EQ(read_image_size(folder_ / "turned.tif"), (ImageSize{1, 2}));
  EXPECT_EQ(size_of(read_picture(folder_ / "turned.tif")), (ImageSize{1, 2}));
}

TEST_F(PictureFormats, JpegsOfPrintersAreRead) {
  const fs::path file = TAGCAL_SOURCE_DIR "/tests/fuzz/corpus/picture/cmyk.jpg";
  const Picture picture = read_picture(file);
  EXPECT_EQ(size_of(picture), read_image_size(file));
  const auto& colours = std::get<ImageRgb>(picture);
  const Image8 grey = read_image(file);
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x) {
      const auto* rgb = &colours(x, y)[0];
      EXPECT_NEAR(grey(x, y), 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2], 0.51);
    }
}

TEST_F(PictureFormats, TiffsThatAreNotReadSayWhy) {
  const auto error = [&](const TiffKind& k) {
    return error_of_file(tiff_of(folder_ / "a.tif", {4, 3}, smooth_values({8, 6}, 4, 1), k));
  };
  TiffKind k;
  k.photometric = PHOTOMETRIC_SEPARATED;
  k.samples = 4;
  EXPECT_HAS(error(k), "picture: TIFF: is CMYK: convert it");
  k = {};
  k.format = SAMPLEFORMAT_INT;
  EXPECT_HAS(error(k), "signed");
  k = {};
  k.kind = 1;
  EXPECT_HAS(error(k), "thumbnail");
  k = {};
  k.photometric = 32803;
  EXPECT_HAS(error(k), "raw");
}

TEST_F(PictureFormats, Bmps) {
  const std::string colour = bmp_of(2, 2, 24, "", "\1\2\3\4\5\6..\7\x8\x9\xa\xb\xc.."s);
  EXPECT_EQ(values_of(read_picture(write("a.bmp", colour))),
            (std::vector<int>{9, 8, 7, 12, 11, 10, 3, 2, 1, 6, 5, 4}));
  const std::string from_above = bmp_of(2, -2, 24, "", "\1\2\3\4\5\6..\7\x8\x9\xa\xb\xc.."s);
  EXPECT_EQ(values_of(read_picture(write("b.bmp", from_above))).front(), 3);
  std::string greys;
  for (int i = 0; i < 256; ++i) greys += std::string(3, static_cast<char>(i)) + '\0';
  const Picture grey = read_picture(write("c.bmp", bmp_of(3, 1, 8, greys, "\1\xc8\3."s)));
  ASSERT_TRUE(std::holds_alternative<Image8>(grey));
  EXPECT_EQ(values_of(grey), (std::vector<int>{1, 200, 3}));
  EXPECT_EQ(read_image(folder_ / "c.bmp").pixels(), (std::vector<std::uint8_t>{1, 200, 3}));
  const std::string two = "\0\0\xff\0\xff\xff\xff\0"s;  // red and white
  EXPECT_EQ(values_of(read_picture(write("d.bmp", bmp_of(2, 1, 1, two, "\x40..."s)))),
            (std::vector<int>{255, 0, 0, 255, 255, 255}));
  std::string compressed = colour;
  compressed[30] = 1;
  EXPECT_HAS(error_of_file(compressed), "compressed");
}

TEST_F(PictureFormats, Webps) {
  const ImageRgb image = colours();
  const Picture read = read_picture(write("a.webp", webp_of(image)));
  ASSERT_TRUE(std::holds_alternative<ImageRgb>(read));
  EXPECT_EQ(std::get<ImageRgb>(read).pixels(), image.pixels());
  EXPECT_EQ(read_image_size(folder_ / "a.webp"), image.size());
  // With the orientation in a chunk: a TIFF header and a directory of one entry.
  const std::string exif = "II*\0\x8\0\0\0\1\0\x12\1\3\0\1\0\0\0\x6\0\0\0\0\0\0\0"s;
  const std::string plain = webp_of(image).substr(12);
  const std::string chunks = "VP8X"s + little_endian(10, 4) + "\x08\0\0\0"s + little_endian(20, 3) +
                             little_endian(12, 3) + plain + "EXIF" +
                             little_endian(static_cast<std::uint32_t>(exif.size()), 4) + exif;
  write("b.webp",
        "RIFF" + little_endian(static_cast<std::uint32_t>(chunks.size() + 4), 4) + "WEBP" + chunks);
  EXPECT_EQ(read_image_size(folder_ / "b.webp"), (ImageSize{13, 21}));
  const auto turned = std::get<ImageRgb>(read_picture(folder_ / "b.webp"));
  EXPECT_EQ(turned(12, 0), image(0, 0));
}

std::vector<std::string> files_of_all_kinds(const fs::path& folder) {
  const fs::path file = folder / "whole.tif";
  TiffKind jpeg;
  jpeg.compression = COMPRESSION_JPEG;
  TiffKind packed;
  packed.compression = COMPRESSION_LZW;
  packed.tiled = true;
  const ImageSize size{37, 23};
  return {tiff_of(file, size, smooth_values(size, 1, 1), {}),
          tiff_of(file, size, smooth_values(size, 1, 1), jpeg),
          tiff_of(file, size, smooth_values(size, 1, 1), packed),
          bmp_of(5, 3, 24, "", std::string(48, 'x')), webp_of(colours())};
}

TEST_F(PictureFormats, CutAnywhereIsAnErrorOfOneLine) {
  for (const std::string& whole : files_of_all_kinds(folder_)) {
    ASSERT_EQ(error_of_file(whole), "no error");
    // A TIFF's last bytes may be values of tags that are not needed.
    const std::size_t most = whole.size() - (whole.starts_with("II") ? 24 : 1);
    for (std::size_t length = 0; length <= most; length += length < 60 ? 1 : 29) {
      const std::string message = error_of_file(whole.substr(0, length));
      ASSERT_TRUE(message.starts_with((folder_ / "picture").string() + ": "))
          << whole.substr(0, 4) << " " << length << " of " << whole.size() << " " << message;
      ASSERT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST_F(PictureFormats, DamageNeverCrashes) {
  Random random(12);
  int errors = 0;
  for (const std::string& whole : files_of_all_kinds(folder_))
    for (int trial = 0; trial < 100; ++trial) {
      std::string damaged = whole;
      for (int i = 0; i < 3; ++i)
        damaged[random.index(damaged.size())] = static_cast<char>(random.index(256));
      errors += error_of_file(damaged) == "no error" ? 0 : 1;
    }
  EXPECT_GT(errors, 50);
}

TEST_F(PictureFormats, TooLargeIsRefusedBeforeItIsAllocated) {
  const std::string limit = "at most 100000000 pixels";
  std::string bmp = bmp_of(5, 3, 24, "", std::string(48, 'x'));
  bmp.replace(18, 8, "\xff\xff\xff\x7f\xff\xff\xff\x7f");
  EXPECT_HAS(error_of_file(bmp), limit);
  std::string tiff = tiff_of(folder_ / "a.tif", {4, 3}, smooth_values({4, 3}, 1, 1), {});
  for (const char tag : {'\0', '\1'}) {  // width and length, of type SHORT
    const std::size_t at = tiff.find(std::string{tag, '\1', '\3', '\0', '\1', '\0', '\0', '\0'});
    ASSERT_NE(at, std::string::npos);
    tiff[at + 8] = tiff[at + 9] = '\xff';
  }
  EXPECT_HAS(error_of_file(tiff), limit);
}

TEST_F(PictureFormats, FormatsThatAreNotReadAreNamed) {
  EXPECT_HAS(error_of_file("GIF89a..."), "is a GIF, which is not read");
  for (const auto& [bytes, name, advice] : {std::array{"0000ftypisom....", "is a video", "@000123"},
                                            {"RIFF....AVI LIST", "is a video", "@000123"},
                                            {"#ROSBAG V2.0\n...", "is a ROS bag", "@000123"},
                                            {"SQLite format 3.", "is a ROS 2 bag", "@000123"}}) {
    const std::string error = error_of_file(bytes);
    EXPECT_HAS(error, name);
    EXPECT_HAS(error, advice);
  }
  EXPECT_HAS(error_of_file("P4 3 3 ..."), "PBM");
}

TEST_F(PictureFormats, HeicOfAPhone) {
  const std::string error = error_of_file(
      "\0\0\0\x18"
      "ftypheic...."s);
  EXPECT_HAS(error, "HEIF: is damaged or truncated");
  if (std::system("heif-enc --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "needs heif-enc";
  Image8 image({80, 64});
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 80; ++x) image(x, y) = static_cast<std::uint8_t>(20 + 2 * x + y);
  write_png(folder_ / "a.png", image);
  const fs::path file = folder_ / "a.heic";
  ASSERT_EQ(std::system(fmt::format("heif-enc -q 100 -o '{}' '{}' >/dev/null 2>&1", file.string(),
                                    (folder_ / "a.png").string())
                            .c_str()),
            0);
  EXPECT_EQ(read_image_size(file), image.size());
  const Image8 read = read_image(file);
  ASSERT_EQ(read.size(), image.size());
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 80; ++x) EXPECT_NEAR(read(x, y), image(x, y), 3) << x << " " << y;
  const std::string bytes = read_text(file);
  for (std::size_t size = 1; size < bytes.size(); size += 37)
    EXPECT_NE(error_of_file(bytes.substr(0, size)), "no error") << size;
}

TEST_F(PictureFormats, TiffsAndJpegsAreWritten) {
  const ImageRgb image = colours();
  Image16 deep({9, 4});
  for (int x = 0; x < 9; ++x) deep(x, 2) = static_cast<std::uint16_t>(7000 * x);
  write_picture(folder_ / "a.tif", image);
  write_picture(folder_ / "b.TIFF", deep);
  EXPECT_EQ(std::get<ImageRgb>(read_picture(folder_ / "a.tif")).pixels(), image.pixels());
  EXPECT_EQ(std::get<Image16>(read_picture(folder_ / "b.TIFF")).pixels(), deep.pixels());
  write_picture(folder_ / "c.jpg", image);
  const std::vector<int> got = values_of(read_picture(folder_ / "c.jpg"));
  const std::vector<int> expected = values_of(image);
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], 12);
  EXPECT_HAS(error_of([&] { write_picture(folder_ / "d.jpg", deep); }), "16 bits");
}

}  // namespace
}  // namespace tagcal
