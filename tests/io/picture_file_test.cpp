// Pictures in their own kind: grey or colour, 8 or 16 bits, as files store them.
#include <cmath>
#include <fstream>

#include "file_fixture.hpp"
#include "jpeg_of.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

using std::string_literals::operator""s;

template <typename T>
Image<T> random_image(const ImageSize& size, Random& random) {
  Image<T> image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if constexpr (std::is_arithmetic_v<T>) {
        image(x, y) = static_cast<T>(random.index(std::numeric_limits<T>::max() + 1ULL));
      } else {
        using Value = typename T::value_type;
        for (Value& value : image(x, y))
          value = static_cast<Value>(random.index(std::numeric_limits<Value>::max() + 1ULL));
      }
    }
  return image;
}

std::vector<Picture> pictures_of_all_kinds() {
  Random random(6);
  const ImageSize size{37, 23};
  return {random_image<std::uint8_t>(size, random), random_image<std::uint16_t>(size, random),
          random_image<Rgb>(size, random), random_image<Rgb16>(size, random)};
}

// The kind and all values.
void expect_equal(const Picture& read, const Picture& written, const std::string& what) {
  ASSERT_EQ(read.index(), written.index()) << what;
  ASSERT_EQ(size_of(read), size_of(written)) << what;
  std::visit(
      [&](const auto& image) {
        EXPECT_TRUE(image.pixels() == std::get<std::decay_t<decltype(image)>>(written).pixels())
            << what;
      },
      read);
}

class PictureFile : public FileTest {};

TEST_F(PictureFile, EveryKindIsReadAsItWasWritten) {
  for (const Picture& picture : pictures_of_all_kinds()) {
    const bool colour = picture.index() >= 2;
    for (const std::string name : {"a.png", "b.PNG", colour ? "c.ppm" : "c.pgm"}) {
      write_picture(folder_ / name, picture);
      expect_equal(read_picture(folder_ / name), picture, name + std::to_string(picture.index()));
      EXPECT_EQ(read_image_size(folder_ / name), size_of(picture));
    }
    std::visit([&](const auto& image) { write_png(folder_ / "d.png", image); }, picture);
    expect_equal(read_picture(folder_ / "d.png"), picture, "write_png");
  }
}

TEST_F(PictureFile, KindsOfNetpbm) {
  expect_equal(read_picture(write("a", "P2 3 1 15 0 1 15")),
               read_picture(write("b", "P5 3 1 255\n\0\x11\xff"s)), "fewer than 8 bits");
  const auto deep = std::get<Image16>(read_picture(write("c", "P2 2 1 4095 7 4095")));
  EXPECT_EQ(deep.pixels(), (std::vector<std::uint16_t>{7, 4095}));  // as stored
  const auto colour = std::get<ImageRgb>(read_picture(write("d", "P3 1 2 255 1 2 3 4 5 6")));
  EXPECT_EQ(colour.pixels(), (std::vector<Rgb>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(read_image(folder_ / "d").pixels(), (std::vector<std::uint8_t>{2, 5}));
  EXPECT_HAS(error_of([&] { read_picture(write("e", "P6 1 2 255\n12345")); }), "truncated");
}

TEST_F(PictureFile, JpegsAreGreyOrColour) {
  Random random(8);
  const Image8 image = random_image<std::uint8_t>({40, 30}, random);
  const Picture grey = read_picture(write("grey.jpg", jpeg_of(image, false)));
  expect_equal(grey, read_image(folder_ / "grey.jpg"), "grey");
  const Picture colour = read_picture(write("colour.jpg", jpeg_of(image, true)));
  ASSERT_TRUE(std::holds_alternative<ImageRgb>(colour));
  EXPECT_EQ(size_of(colour), image.size());
}

// A picture without detail that a quarter of its pixels would not show.
Image8 smooth_image(const ImageSize& size) {
  Image8 image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      image(x, y) =
          static_cast<std::uint8_t>(128 + 60 * std::sin(x / 20.0) + 50 * std::cos(y / 25.0));
  return image;
}

// Mean of a square of pixels.
double mean_of(const Image8& image, int x, int y, int side) {
  double sum = 0;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) sum += image(side * x + i, side * y + j);
  return sum / (side * side);
}

TEST_F(PictureFile, ReducedJpegsAreMeansOfTheFullOnes) {
  const fs::path file = write("a.jpg", jpeg_of(smooth_image({320, 240}), false));
  const Image8 full = read_image(file);
  for (const auto& [least_width, shrink] :
       {std::pair{40, 8}, {41, 4}, {80, 4}, {160, 2}, {161, 1}, {999, 1}}) {
    const auto reduced = std::get<Image8>(read_reduced(file, least_width));
    ASSERT_EQ(reduced.size(), (ImageSize{320 / shrink, 240 / shrink})) << least_width;
    for (int y = 0; y < reduced.height(); ++y)
      for (int x = 0; x < reduced.width(); ++x)
        ASSERT_NEAR(reduced(x, y), mean_of(full, x, y, shrink), 1.5) << least_width;
  }
}

TEST_F(PictureFile, OnlyWholeSquaresAreReduced) {
  const auto width = [&](const ImageSize& size) {
    return size_of(read_reduced(write("a.jpg", jpeg_of(smooth_image(size), true)), 10)).width;
  };
  EXPECT_EQ(width({320, 240}), 40);
  EXPECT_EQ(width({320, 244}), 80);
  EXPECT_EQ(width({321, 240}), 321);
  write_png(folder_ / "a.png", smooth_image({320, 240}));
  EXPECT_EQ(size_of(read_reduced(folder_ / "a.png", 10)).width, 320);
  const std::string bytes = jpeg_of(smooth_image({320, 240}), false);
  EXPECT_HAS(
      error_of([&] { read_reduced(write("cut.jpg", bytes.substr(0, bytes.size() / 2)), 10); }),
      "cut.jpg: JPEG: is truncated");
}

TEST_F(PictureFile, JpegsAreEncodedIntoMemory) {
  const Image8 image = smooth_image({64, 48});
  const std::string fine = jpeg_bytes(image, 95), coarse = jpeg_bytes(image, 40);
  EXPECT_LT(coarse.size(), fine.size());
  const Image8 read = read_image(write("a.jpg", fine));
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) ASSERT_NEAR(read(x, y), image(x, y), 4);
  EXPECT_HAS(error_of([] { jpeg_bytes(Image16({4, 3}), 75); }), "16 bits");
}

TEST_F(PictureFile, PicturesOfAFolderAreListedByName) {
  for (const char* name : {"b.TIF", "a.png", "c.webp", ".hidden.png", "notes.txt", "d.ppm~"})
    write(name, "");
  fs::create_directory(folder_ / "below");
  EXPECT_EQ(list_pictures(folder_),
            (std::vector<fs::path>{folder_ / "a.png", folder_ / "b.TIF", folder_ / "c.webp"}));
  EXPECT_HAS(error_of([&] { list_pictures(folder_ / "none"); }), "must be a folder");
}

TEST_F(PictureFile, WhatCannotBeWrittenIsSaid) {
  const auto error = [&](const std::string& name, const Picture& picture) {
    return error_of([&] { write_picture(folder_ / name, picture); });
  };
  const Picture grey = Image8({4, 3}), colour = ImageRgb({4, 3});
  EXPECT_HAS(error("a.gif", grey), "a.gif: the name of a picture must end in .png");
  EXPECT_HAS(error("a", grey), "must end in");
  EXPECT_HAS(error("a.pgm", colour), "write a .ppm");
  EXPECT_HAS(error("a.png", Image8()), "must be > 0");
  EXPECT_EQ(num_files(), 0U);
}

}  // namespace
}  // namespace tagcal
