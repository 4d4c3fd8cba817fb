#include "tagcal/io/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image/image_orientation.hpp"
#include "tagcal/io/text/text_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr std::uintmax_t kMaxFileBytes = 1ULL << 30;
constexpr std::int64_t kMaxPixels = 100'000'000;

std::string read_bytes(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw Error("no such file");
  if (std::filesystem::is_directory(status)) throw Error("is a folder, not a picture");
  if (!std::filesystem::is_regular_file(status)) throw Error("is not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw Error("cannot be read: " + error.message());
  if (size == 0) throw Error("is empty");
  if (size > kMaxFileBytes) throw Error("is larger than 1 GiB");
  std::string bytes(size, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    throw Error("cannot be read");
  }
  return bytes;
}

void check_size(std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0) {
    throw Error(fmt::format("width and height must be > 0, got {}x{}", width, height));
  }
  if (width > kMaxPixels || height > kMaxPixels || width * height > kMaxPixels) {
    throw Error(fmt::format("must have at most {} pixels, got {}x{}", kMaxPixels, width, height));
  }
}

// Netpbm's grey formats: P2 (decimal text) and P5 (binary, 16-bit values with the high byte first).
class PgmDecoder : public ImageDecoder {
 public:
  explicit PgmDecoder(std::string_view bytes) : rest_(bytes.substr(2)), text_(bytes[1] == '2') {
    header_.width = next_number("the width");
    header_.height = next_number("the height");
    max_value_ = next_number("the largest value");
    if (max_value_ < 1 || max_value_ > 65535) {
      throw Error(fmt::format("the largest value must be 1 to 65535, got {}", max_value_));
    }
    header_.sixteen_bit = max_value_ > 255;
    header_.white = header_.sixteen_bit ? 65535 : max_value_;
    if (!text_) rest_.remove_prefix(std::min<std::size_t>(1, rest_.size()));  // one white space
  }

  Header header() const override { return header_; }

  void decode(const RowSink& sink) override {
    std::vector<std::uint16_t> row(static_cast<std::size_t>(header_.width));
    const std::size_t left = (text_                 ? 2
                              : header_.sixteen_bit ? 2
                                                    : 1) *
                             row.size() * static_cast<std::size_t>(header_.height);
    if (rest_.size() + (text_ ? 1 : 0) < left) throw Error("is truncated");
    for (int y = 0; y < header_.height; ++y) {
      for (std::uint16_t& value : row) value = text_ ? next_text_value() : next_binary_value();
      sink(y, row.data());
    }
  }

 private:
  int next_number(const char* what) {
    skip_space();
    int value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc() || value < 0) {
      throw Error(fmt::format("is not a PGM picture, or truncated: {} is missing", what));
    }
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  void skip_space() {
    while (!rest_.empty()) {
      if (rest_.front() == '#') {
        rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
      } else if (std::strchr(" \t\r\n\v\f", rest_.front()) && rest_.front() != '\0') {
        rest_.remove_prefix(1);
      } else {
        return;
      }
    }
  }

  std::uint16_t checked(int value) const {
    if (value > max_value_) {
      throw Error(fmt::format("values must be at most {}, got {}", max_value_, value));
    }
    return static_cast<std::uint16_t>(value);
  }

  std::uint16_t next_text_value() { return checked(next_number("a value")); }

  std::uint16_t next_binary_value() {
    const auto byte = [&] {
      const auto value = static_cast<std::uint8_t>(rest_.front());
      rest_.remove_prefix(1);
      return value;
    };
    const int high = header_.sixteen_bit ? byte() : 0;
    return checked(high * 256 + byte());
  }

  std::string_view rest_;
  bool text_;
  int max_value_ = 0;
  Header header_;
};

std::unique_ptr<ImageDecoder> open_image(std::string_view bytes) {
  using std::string_view_literals::operator""sv;
  std::unique_ptr<ImageDecoder> decoder;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) {
    decoder = png_decoder(bytes);
  } else if (bytes.starts_with("\xff\xd8\xff"sv)) {
    decoder = jpeg_decoder(bytes);
  } else if (bytes.starts_with("P5"sv) || bytes.starts_with("P2"sv)) {
    decoder = std::make_unique<PgmDecoder>(bytes);
  } else {
    throw Error("is not a PNG, JPEG or PGM picture, or truncated");
  }
  check_size(decoder->header().width, decoder->header().height);
  return decoder;
}

Image8 scaled(const Image16& image, int white) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y) {
    const std::uint16_t* in = image.row(y);
    std::transform(in, in + image.width(), result.row(y), [&](int value) {
      return static_cast<std::uint8_t>(std::min(255, (value * 255 + white / 2) / white));
    });
  }
  return result;
}

// The 16-bit value that becomes white. Sensors of 10 to 14 bits store unscaled values, and files do
// not say so: white is the brightest pixel, but at most twice the 99.9 % quantile, which excludes a
// lamp or a hot pixel in a dark picture.
int white_of(const Image16& image) {
  std::vector<std::uint32_t> count(65536, 0);
  for (const std::uint16_t value : image.pixels()) ++count[value];
  int brightest = 0;
  for (int value = 65535; value > 0 && brightest == 0; --value)
    if (count[static_cast<std::size_t>(value)] > 0) brightest = value;
  std::size_t above = 0;
  int usual = brightest;
  while (usual > 0 &&
         (above += count[static_cast<std::size_t>(usual)]) <= image.pixels().size() / 1000)
    --usual;
  return std::clamp(2 * usual, 1, std::max(1, brightest));
}

Image8 decode_as_stored(std::string_view bytes) {
  const auto decoder = open_image(bytes);
  const ImageDecoder::Header header = decoder->header();
  const ImageSize size{header.width, header.height};
  if (!header.sixteen_bit && header.white == 255) {
    Image8 image(size);
    decoder->decode([&](int y, const std::uint16_t* row) {
      std::transform(row, row + size.width, image.row(y),
                     [](std::uint16_t value) { return static_cast<std::uint8_t>(value); });
    });
    return image;
  }
  Image16 image(size);
  decoder->decode([&](int y, const std::uint16_t* row) {
    std::copy_n(row, static_cast<std::size_t>(size.width), image.row(y));
  });
  return scaled(image, header.sixteen_bit ? white_of(image) : header.white);
}

// Runs a reader and adds the file's name to its errors.
template <typename Function>
auto naming(const std::filesystem::path& file, Function function) {
  try {
    return function();
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
}

template <typename Picture>
std::string encoded(const std::filesystem::path& file, const Picture& image,
                    double pixels_per_inch = 0) {
  return naming(file, [&] {
    check_size(image.width(), image.height());
    return encode_png(image, pixels_per_inch);
  });
}

}  // namespace

Image8 read_image(const std::filesystem::path& file) {
  return naming(file, [&] {
    const std::string bytes = read_bytes(file);
    return upright(decode_as_stored(bytes), exif_orientation(bytes));
  });
}

ImageSize read_image_size(const std::filesystem::path& file) {
  return naming(file, [&] {
    const std::string bytes = read_bytes(file);
    const ImageDecoder::Header header = open_image(bytes)->header();
    const ImageSize stored{header.width, header.height};
    return swaps_sides(exif_orientation(bytes)) ? ImageSize{stored.height, stored.width} : stored;
  });
}

void write_png(const std::filesystem::path& file, const Image8& image, double pixels_per_inch) {
  write_whole(file, encoded(file, image, pixels_per_inch));
}

void write_png(const std::filesystem::path& file, const Image16& image) {
  write_whole(file, encoded(file, image));
}

void write_png(const std::filesystem::path& file, const ImageRgb& image) {
  write_whole(file, encoded(file, image));
}

}  // namespace tagcal
