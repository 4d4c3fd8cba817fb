#include "tagcal/io/image/image_codec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

// Formats by their bytes from `offset` on. Those without a decoder are named in the error.
struct Format {
  std::string_view bytes;
  std::size_t offset = 0;
  std::unique_ptr<ImageDecoder> (*decoder)(std::string_view bytes) = nullptr;
  const char* name = "";
  const char* advice = "convert it to PNG";
};

constexpr const char* kTakeOut =
    "name one of its frames, FILE@000123, whose FILE ends in .mp4, .mov, .avi, .mkv, .webm or "
    ".mjpeg";
constexpr const char* kFromBag =
    "name one of its frames, FILE:/topic@000123, whose FILE ends in .bag, .mcap or .db3";

constexpr Format kFormats[] = {
    {"\x89PNG\r\n\x1a\n"sv, 0, png_decoder},
    {"\xff\xd8\xff"sv, 0, jpeg_decoder},
    {"II*\0"sv, 0, tiff_decoder},
    {"MM\0*"sv, 0, tiff_decoder},
    {"II+\0"sv, 0, tiff_decoder},  // BigTIFF
    {"MM\0+"sv, 0, tiff_decoder},
    {"WEBPVP8"sv, 8, webp_decoder},
    {"BM"sv, 0, bmp_decoder},
    {"P2"sv, 0, netpbm_decoder},
    {"P3"sv, 0, netpbm_decoder},
    {"P5"sv, 0, netpbm_decoder},
    {"P6"sv, 0, netpbm_decoder},
    {"P1"sv, 0, nullptr, "a PBM (of one bit)"},
    {"P4"sv, 0, nullptr, "a PBM (of one bit)"},
    {"P7"sv, 0, nullptr, "a PAM"},
    {"GIF8"sv, 0, nullptr, "a GIF"},
    {"ftyphei"sv, 4, heif_decoder},
    {"ftyphev"sv, 4, heif_decoder},
    {"ftypmif1"sv, 4, heif_decoder},
    {"ftypavif"sv, 4, heif_decoder},
    {"ftypcrx"sv, 4, nullptr, "a raw picture (CR3)"},
    {"ftyp"sv, 4, nullptr, "a video", kTakeOut},
    {"AVI "sv, 8, nullptr, "a video", kTakeOut},
    {"\x1a\x45\xdf\xa3"sv, 0, nullptr, "a video", kTakeOut},  // Matroska, WebM
    {"#ROSBAG"sv, 0, nullptr, "a ROS bag", kFromBag},
    {"SQLite format 3"sv, 0, nullptr, "a ROS 2 bag", kFromBag},
    {"\x89MCAP0"sv, 0, nullptr, "a ROS 2 bag", kFromBag},
    {"jP  \r\n\x87\n"sv, 4, nullptr, "a JPEG 2000 picture"},
    {"\xff\x0a"sv, 0, nullptr, "a JPEG XL picture"},
    {"v/1\x01"sv, 0, nullptr, "an OpenEXR picture"},
    {"FUJIFILM"sv, 0, nullptr, "a raw picture (RAF)"},
};

}  // namespace

std::optional<std::uint64_t> number_at(std::string_view bytes, std::uint64_t at, std::size_t count,
                                       bool big_endian) {
  if (at > bytes.size() || bytes.size() - at < count) return std::nullopt;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
    value = value * 256 + static_cast<std::uint8_t>(bytes[at + (big_endian ? i : count - 1 - i)]);
  return value;
}

void check_picture_size(std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0) {
    throw Error(fmt::format("width and height must be > 0, got {}x{}", width, height));
  }
  if (width > limits::kMaxPixels || height > limits::kMaxPixels ||
      width * height > limits::kMaxPixels) {
    throw Error(
        fmt::format("must have at most {} pixels, got {}x{}", limits::kMaxPixels, width, height));
  }
}

void check_picture_size(std::int64_t width, std::int64_t height, std::size_t num_bytes) {
  check_picture_size(width, height);
  const std::int64_t most = std::max(
      limits::kMaxPixelsOfFewBytes, limits::kMaxPixelsAByte * static_cast<std::int64_t>(num_bytes));
  if (width * height > most)
    throw Error(
        fmt::format("{}x{} pixels cannot be in a file of {} bytes", width, height, num_bytes));
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
  for (const Format& format : kFormats) {
    if (bytes.size() < format.offset || !bytes.substr(format.offset).starts_with(format.bytes))
      continue;
    if (format.decoder) return format.decoder(bytes);
    throw Error(fmt::format("is {}, which is not read: {}", format.name, format.advice));
  }
  throw Error("is not a PNG, JPEG, TIFF, BMP, WebP, HEIC, PGM or PPM picture, or truncated");
}

}  // namespace tagcal::internal
