#include "tagcal/io/sequence/ros_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <string>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/bag_bytes.hpp"

namespace tagcal::internal {
namespace {

constexpr std::string_view kImage = "sensor_msgs/Image";
constexpr std::string_view kCompressed = "sensor_msgs/CompressedImage";

// Encodings (sensor_msgs/image_encodings.h): values of a pixel, bytes of a value, and where red,
// green and blue are among them; or the filters of 2 x 2 pixels by rows, 0 to 2 for red to blue.
struct Encoding {
  std::string_view name;
  int num_values;
  int num_bytes;
  std::array<int, 3> places;  // all equal: grey
  std::array<int, 4> filters = {};
  bool is_mosaic() const { return filters != std::array<int, 4>{}; }
  bool is_grey() const { return !is_mosaic() && places[0] == places[1]; }
};
constexpr std::array kRgb{0, 1, 2}, kBgr{2, 1, 0}, kFirst{0, 0, 0}, kSecond{1, 1, 1};
constexpr std::array kRggb{0, 1, 1, 2}, kBggr{2, 1, 1, 0}, kGbrg{1, 2, 0, 1}, kGrbg{1, 0, 2, 1};
constexpr Encoding kEncodings[] = {
    {"mono8", 1, 1, kFirst},
    {"8UC1", 1, 1, kFirst},
    {"mono16", 1, 2, kFirst},
    {"16UC1", 1, 2, kFirst},
    {"rgb8", 3, 1, kRgb},
    {"bgr8", 3, 1, kBgr},
    {"8UC3", 3, 1, kBgr},
    {"rgba8", 4, 1, kRgb},
    {"bgra8", 4, 1, kBgr},
    {"8UC4", 4, 1, kBgr},
    {"rgb16", 3, 2, kRgb},
    {"bgr16", 3, 2, kBgr},
    {"16UC3", 3, 2, kBgr},
    {"rgba16", 4, 2, kRgb},
    {"bgra16", 4, 2, kBgr},
    {"bayer_rggb8", 1, 1, kFirst, kRggb},
    {"bayer_bggr8", 1, 1, kFirst, kBggr},
    {"bayer_gbrg8", 1, 1, kFirst, kGbrg},
    {"bayer_grbg8", 1, 1, kFirst, kGrbg},
    {"bayer_rggb16", 1, 2, kFirst, kRggb},
    {"bayer_bggr16", 1, 2, kFirst, kBggr},
    {"bayer_gbrg16", 1, 2, kFirst, kGbrg},
    {"bayer_grbg16", 1, 2, kFirst, kGrbg},
    {"yuv422", 2, 1, kSecond},  // U Y V Y
    {"uyvy", 2, 1, kSecond},
    {"yuv422_yuy2", 2, 1, kFirst},  // Y U Y V
    {"yuyv", 2, 1, kFirst},
};

// The bytes of an uncompressed picture.
struct RawPixels {
  const Encoding* encoding = nullptr;
  bool big_endian = false;
  std::size_t step = 0;  // bytes of a row
  std::string_view bytes;

  std::uint16_t value(int x, int y, int place) const {
    const Encoding& e = *encoding;
    const std::size_t at = static_cast<std::size_t>(y) * step +
                           (static_cast<std::size_t>(x) * e.num_values + place) * e.num_bytes;
    const auto first = static_cast<std::uint8_t>(bytes[at]);
    if (e.num_bytes == 1) return first;
    const auto second = static_cast<std::uint8_t>(bytes[at + 1]);
    return static_cast<std::uint16_t>(big_endian ? first << 8 | second : second << 8 | first);
  }
};

class RawDecoder : public ImageDecoder {
 public:
  RawDecoder(const RawPixels& pixels, std::uint32_t width, std::uint32_t height) : pixels_(pixels) {
    const Encoding& encoding = *pixels.encoding;
    check_picture_size(width, height);
    header_.width = static_cast<int>(width);
    header_.height = static_cast<int>(height);
    header_.channels = encoding.is_grey() ? 1 : 3;
    header_.sixteen_bit = encoding.num_bytes == 2;
    header_.white = header_.sixteen_bit ? 65535 : 255;
    const std::size_t row = std::size_t{width} * encoding.num_values * encoding.num_bytes;
    if (pixels.step < row || pixels.bytes.size() / pixels.step < height)
      throw Error(
          fmt::format("a picture of {}x{} pixels ({}) needs rows of {} bytes, it has {} "
                      "bytes in rows of {}",
                      width, height, encoding.name, row, pixels.bytes.size(), pixels.step));
  }

  void decode(const RowSink& sink) override {
    std::vector<std::uint16_t> row(static_cast<std::size_t>(header_.width) * header_.channels);
    for (int y = 0; y < header_.height; ++y) {
      for (int x = 0; x < header_.width; ++x) {
        if (header_.channels == 1) {
          row[x] = pixels_.value(x, y, pixels_.encoding->places[0]);
          continue;
        }
        for (int c = 0; c < 3; ++c) row[3 * x + c] = colour(x, y, c);
      }
      sink(y, row.data());
    }
  }

 private:
  std::uint16_t colour(int x, int y, int c) const {
    if (pixels_.encoding->is_mosaic()) return interpolated(x, y, c);
    return pixels_.value(x, y, pixels_.encoding->places[c]);
  }

  bool has_filter(int x, int y, int c) const {
    return pixels_.encoding->filters[2 * (y & 1) + (x & 1)] == c;
  }

  // The mean of the pixels of this filter among the eight neighbours: linear interpolation.
  std::uint16_t interpolated(int x, int y, int c) const {
    if (has_filter(x, y, c)) return pixels_.value(x, y, 0);
    unsigned sum = 0, count = 0;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, header_.height - 1); ++v)
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, header_.width - 1); ++u) {
        if (!has_filter(u, v, c)) continue;
        sum += pixels_.value(u, v, 0);
        ++count;
      }
    return count == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>((sum + count / 2) / count);
  }

  RawPixels pixels_;
};

// A message's values after its first bytes, aligned where its coding says so.
class MessageReader {
 public:
  MessageReader(std::string_view message, RosCoding coding)
      : is_cdr_(coding == RosCoding::cdr), reader_(start(message)) {}

  std::uint32_t whole() {
    if (is_cdr_) reader_.align(4);
    return reader_.next<std::uint32_t>();
  }
  std::uint8_t byte() { return reader_.next<std::uint8_t>(); }
  std::string_view bytes() { return reader_.take(whole()); }
  std::string_view text() {
    std::string_view text = bytes();
    if (is_cdr_ && text.ends_with('\0')) text.remove_suffix(1);
    return text;
  }
  std::int64_t stamp_ns() {
    const std::uint32_t seconds = whole();
    return ns_of(seconds, whole());
  }
  // The header of a message: of ROS 1 with a number, its stamp, the name of a frame.
  std::int64_t header_stamp_ns() {
    if (!is_cdr_) whole();
    return stamp_ns();
  }

 private:
  // Of CDR behind the four bytes that name the order of bytes.
  ByteReader start(std::string_view message) const {
    if (!is_cdr_) return ByteReader(message);
    if (message.size() < 4) throw Damage();
    return ByteReader(message.substr(4), (message[1] & 1) == 0);
  }

  bool is_cdr_;
  ByteReader reader_;
};

std::unique_ptr<ImageDecoder> raw_decoder(MessageReader& reader) {
  const std::uint32_t height = reader.whole(), width = reader.whole();
  const std::string_view name = reader.text();
  const auto encoding = std::ranges::find(kEncodings, name, &Encoding::name);
  if (encoding == std::end(kEncodings))
    throw Error(
        fmt::format("has pictures of encoding \"{}\", which is not read (mono, rgb, bgr, "
                    "bayer of 8 and 16 bits, yuv422)",
                    name.substr(0, 40)));
  RawPixels pixels{.encoding = encoding};
  pixels.big_endian = reader.byte() != 0;
  pixels.step = reader.whole();
  pixels.bytes = reader.bytes();
  return std::make_unique<RawDecoder>(pixels, width, height);
}

std::unique_ptr<ImageDecoder> compressed_decoder(MessageReader& reader) {
  if (reader.text().find("compressedDepth") != std::string_view::npos)
    throw Error("has maps of depth, no pictures");
  return image_decoder(reader.bytes());
}

}  // namespace

bool is_ros_picture(std::string_view type) { return type == kImage || type == kCompressed; }

std::int64_t ns_of(std::uint32_t seconds, std::uint32_t nanoseconds) {
  return std::int64_t{seconds} * 1'000'000'000 + nanoseconds;
}

std::int64_t ros_stamp_ns(std::string_view begin, RosCoding coding) {
  try {
    return MessageReader(begin, coding).header_stamp_ns();
  } catch (const Damage&) {
    return 0;
  }
}

std::unique_ptr<ImageDecoder> ros_picture_decoder(std::string_view message, std::string_view type,
                                                  RosCoding coding) {
  try {
    MessageReader reader(message, coding);
    reader.header_stamp_ns();
    reader.text();
    return type == kImage ? raw_decoder(reader) : compressed_decoder(reader);
  } catch (const Damage&) {
    throw Error("has a message that ends within its picture");
  }
}

}  // namespace tagcal::internal
