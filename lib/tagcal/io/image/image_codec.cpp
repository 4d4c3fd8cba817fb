#include "tagcal/io/image/image_codec.hpp"

#include <fmt/format.h>

#include <vector>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::int64_t kMaxPixels = 100'000'000;

struct Format {
  std::string_view first_bytes;
  std::unique_ptr<ImageDecoder> (*decoder)(std::string_view bytes);
};

constexpr Format kFormats[] = {
    {"\x89PNG\r\n\x1a\n"sv, png_decoder},
    {"\xff\xd8\xff"sv, jpeg_decoder},
    {"P2"sv, netpbm_decoder},
    {"P3"sv, netpbm_decoder},
    {"P5"sv, netpbm_decoder},
    {"P6"sv, netpbm_decoder},
};

}  // namespace

void check_picture_size(std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0) {
    throw Error(fmt::format("width and height must be > 0, got {}x{}", width, height));
  }
  if (width > kMaxPixels || height > kMaxPixels || width * height > kMaxPixels) {
    throw Error(fmt::format("must have at most {} pixels, got {}x{}", kMaxPixels, width, height));
  }
}

void ImageDecoder::decode_grey(const RowSink& sink) {
  if (header_.channels == 1) return decode(sink);
  std::vector<std::uint16_t> grey(static_cast<std::size_t>(header_.width));
  decode([&](int y, const std::uint16_t* row) {
    for (std::uint16_t& value : grey) {
      value = static_cast<std::uint16_t>(
          (299ULL * row[0] + 587ULL * row[1] + 114ULL * row[2] + 500) / 1000);  // numeric: Rec. 601
      row += 3;
    }
    sink(y, grey.data());
  });
}

std::unique_ptr<ImageDecoder> image_decoder(std::string_view bytes) {
  for (const Format& format : kFormats)
    if (bytes.starts_with(format.first_bytes)) return format.decoder(bytes);
  throw Error("is not a PNG, JPEG, PGM or PPM picture, or truncated");
}

}  // namespace tagcal::internal
