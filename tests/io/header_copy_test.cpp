// Sizes of pictures from their headers, wherever in the file these are.
#include "tagcal/io/image/header_copy.hpp"

#include <fcntl.h>
#include <webp/encode.h>

#include "file_fixture.hpp"
#include "jpeg_of.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

using std::string_literals::operator""s;

// Noise, so that no format makes it smaller than what is read of every file.
Image8 noise() {
  Random random(7);
  Image8 image({600, 400});
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image(x, y) = static_cast<std::uint8_t>(random.index(256));
  return image;
}

// Exif: turned by 90 degrees, which swaps width and height.
const std::string kTurnedTag =
    "MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"s;

std::string number(std::size_t value, bool big_endian) {
  std::string text;
  for (int i = 0; i < 4; ++i)
    text += static_cast<char>(value >> (8 * (big_endian ? 3 - i : i)) & 255U);
  return text;
}

std::string turned_png(const std::string& png) {
  const std::string chunk = number(kTurnedTag.size(), true) + "eXIf" + kTurnedTag + "\0\0\0\0"s;
  return std::string(png).insert(png.size() - 12, chunk);
}

// Behind four segments of 60 kB.
std::string turned_jpeg(const std::string& jpeg) {
  const auto segment = [](char marker, const std::string& data) {
    return "\xff"s + marker + number(data.size() + 2, true).substr(2) + data;
  };
  std::string segments;
  for (int i = 0; i < 4; ++i) segments += segment('\xe2', std::string(60000, '\0'));
  return jpeg.substr(0, 2) + segments + segment('\xe1', "Exif\0\0"s + kTurnedTag) + jpeg.substr(2);
}

// With its Exif behind the pixels.
std::string turned_webp(const Image8& image) {
  std::string rgb;
  for (const std::uint8_t value : image.pixels()) rgb.append(3, static_cast<char>(value));
  std::uint8_t* out = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGB(reinterpret_cast<const std::uint8_t*>(rgb.data()), image.width(),
                            image.height(), 3 * image.width(), &out);
  const std::string pixels(reinterpret_cast<char*>(out) + 12, size - 12);
  WebPFree(out);
  const std::string canvas = number(image.width() - 1, false).substr(0, 3) +
                             number(image.height() - 1, false).substr(0, 3);
  const std::string chunks = "WEBPVP8X" + number(10, false) + "\x08\0\0\0"s + canvas + pixels +
                             "EXIF" + number(kTurnedTag.size(), false) + kTurnedTag;
  return "RIFF" + number(chunks.size(), false) + chunks;
}

class HeaderCopyTest : public FileTest {};

TEST_F(HeaderCopyTest, SizesAreThoseOfThePictures) {
  const Image8 image = noise();
  for (const char* name : {"a.png", "a.tif", "a.jpg", "a.pgm"})
    write_picture(folder_ / name, image);
  write("turned.png", turned_png(read_text(folder_ / "a.png")));
  write("turned.jpg", turned_jpeg(jpeg_of(image, true)));
  write("turned.webp", turned_webp(image));
  int num_turned = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_GT(fs::file_size(entry), 100'000u) << entry;
    EXPECT_EQ(read_image_size(entry), read_image(entry).size()) << entry;
    num_turned += read_image_size(entry) == ImageSize{400, 600} ? 1 : 0;
  }
  EXPECT_EQ(num_turned, 3);
}

// A mapping of the file would end the program here, by SIGBUS.
TEST_F(HeaderCopyTest, AFileThatBecomesShorterIsAnError) {
  write_picture(folder_ / "a.png", noise());
  const std::size_t size = fs::file_size(folder_ / "a.png");
  fs::resize_file(folder_ / "a.png", 5000);
  const int descriptor = ::open((folder_ / "a.png").c_str(), O_RDONLY | O_CLOEXEC);
  EXPECT_ERROR(internal::HeaderCopy(descriptor, size), "cannot be read: became shorter meanwhile");
  ::close(descriptor);
}

}  // namespace
}  // namespace tagcal
