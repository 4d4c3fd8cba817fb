// Pictures that the Exif tag Orientation turns or mirrors.
#include <gtest/gtest.h>

#include "file_fixture.hpp"
#include "jpeg_of.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

using std::string_literals::operator""s;

std::string two(int value, bool big_endian) {
  const char high = static_cast<char>(value / 256);
  const char low = static_cast<char>(value % 256);
  return big_endian ? std::string{high, low} : std::string{low, high};
}

// A TIFF header and a directory of two entries, the second of which is the orientation.
std::string tiff_with(int orientation, bool big_endian) {
  const auto n = [&](int value) { return two(value, big_endian); };
  const auto n4 = [&](int value) { return big_endian ? n(0) + n(value) : n(value) + n(0); };
  return (big_endian ? "MM" : "II") + n(42) + n4(8) + n(2) +  //
         n(0x010f) + n(2) + n4(4) + "cam\0"s +                //
         n(0x0112) + n(3) + n4(1) + n(orientation) + n(0) + n4(0);
}

std::string with_exif(const std::string& jpeg, const std::string& tiff) {
  const std::string segment = "Exif\0\0"s + tiff;
  return jpeg.substr(0, 2) + "\xff\xe1" + two(static_cast<int>(segment.size()) + 2, true) +
         segment + jpeg.substr(2);
}

// After the header (33 bytes) or before the end (12 bytes); libpng reads past a wrong checksum
// here.
std::string with_chunk(const std::string& png, const std::string& tiff, bool after_header) {
  const std::string chunk =
      "\0\0"s + two(static_cast<int>(tiff.size()), true) + "eXIf" + tiff + "\0\0\0\0"s;
  return std::string(png).insert(after_header ? 33 : png.size() - 12, chunk);
}

// Place at which the pixel (x, y) of the upright picture is stored (Exif 2.32, 4.6.4 A).
std::pair<int, int> stored_place(int orientation, int x, int y, const ImageSize& stored) {
  const int right = stored.width - 1;
  const int bottom = stored.height - 1;
  switch (orientation) {
    case 2:
      return {right - x, y};
    case 3:
      return {right - x, bottom - y};
    case 4:
      return {x, bottom - y};
    case 5:
      return {y, x};
    case 6:
      return {y, bottom - x};
    case 7:
      return {right - y, bottom - x};
    case 8:
      return {right - y, x};
    default:
      return {x, y};
  }
}

class ImageOrientation : public FileTest {
 protected:
  void SetUp() override {
    Image8 image({40, 24});
    Random random(5);
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 40; ++x) image(x, y) = static_cast<std::uint8_t>(random.index(256));
    jpeg_ = jpeg_of(image, true);
    write_png(file_, image);
    png_ = read_text(file_);
  }

  fs::path put(const std::string& bytes) const { return write("picture", bytes); }

  void expect_turned(const std::string& tagged, const Image8& stored, int orientation) const {
    const Image8 seen = read_image(put(tagged));
    const ImageSize size = orientation >= 5 ? ImageSize{24, 40} : ImageSize{40, 24};
    ASSERT_EQ(seen.size(), size) << orientation;
    EXPECT_EQ(read_image_size(file_), size) << orientation;
    for (int y = 0; y < seen.height(); ++y) {
      for (int x = 0; x < seen.width(); ++x) {
        const auto [u, v] = stored_place(orientation, x, y, stored.size());
        ASSERT_EQ(seen(x, y), stored(u, v)) << orientation << " at " << x << ", " << y;
      }
    }
  }

  fs::path file_ = folder_ / "picture";
  std::string jpeg_, png_;
};

TEST_F(ImageOrientation, ReducedPicturesAreUpright) {
  Image8 image({40, 24});  // dark, but for the upper left quarter
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 40; ++x) image(x, y) = x < 16 && y < 8 ? 250 : 10;
  const std::string jpeg = jpeg_of(image, false);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    put(with_exif(jpeg, tiff_with(orientation, true)));
    const Image8 full = read_image(file_);
    const auto reduced = std::get<Image8>(read_reduced(file_, 3));
    ASSERT_EQ(reduced.size(), (ImageSize{full.width() / 8, full.height() / 8})) << orientation;
    for (int y = 0; y < reduced.height(); ++y)
      for (int x = 0; x < reduced.width(); ++x)
        EXPECT_NEAR(reduced(x, y), full(8 * x + 4, 8 * y + 4), 8) << orientation;
  }
}

TEST_F(ImageOrientation, EachIsAppliedToJpegs) {
  const Image8 stored = read_image(put(jpeg_));
  ASSERT_EQ(stored.size(), (ImageSize{40, 24}));
  for (int orientation = 0; orientation <= 9; ++orientation) {  // 0 and 9 mean nothing
    for (const bool big_endian : {false, true}) {
      expect_turned(with_exif(jpeg_, tiff_with(orientation, big_endian)), stored,
                    orientation % 9 == 0 ? 1 : orientation);
    }
  }
}

TEST_F(ImageOrientation, EachIsAppliedToPngs) {
  const Image8 stored = read_image(put(png_));
  for (int orientation = 1; orientation <= 8; ++orientation) {
    expect_turned(with_chunk(png_, tiff_with(orientation, true), true), stored, orientation);
    expect_turned(with_chunk(png_, tiff_with(orientation, false), false), stored, orientation);
  }
}

TEST_F(ImageOrientation, ASegmentOfAnotherKindMayComeFirst) {
  const std::string tagged = with_exif(jpeg_, tiff_with(6, false));
  const std::string xmp = "\xff\xe1\0\x0bhttp://ns\xff"s;  // and a fill byte
  expect_turned(tagged.substr(0, 2) + xmp + tagged.substr(2), read_image(put(jpeg_)), 6);
}

// The picture is read, turned or not.
TEST_F(ImageOrientation, DamagedTagsHarmNothing) {
  const std::string whole = tiff_with(6, false);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NO_THROW(read_image(put(with_exif(jpeg_, whole.substr(0, length))))) << length;
    EXPECT_NO_THROW(read_image(put(with_chunk(png_, whole.substr(0, length), true)))) << length;
  }
  Random random(7);
  int as_stored = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = whole;
    for (int i = 0; i < 3; ++i)
      damaged[random.index(damaged.size())] = static_cast<char>(random.index(256));
    Image8 image;
    EXPECT_NO_THROW(image = read_image(put(with_exif(jpeg_, damaged))));
    as_stored += image.width() == 40 ? 1 : 0;
  }
  EXPECT_GT(as_stored, 100);
  EXPECT_LT(as_stored, 300);
}

}  // namespace
}  // namespace tagcal
