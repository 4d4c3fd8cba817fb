#include "tagcal/io/image/image_codec.hpp"

#include <cstdint>
#include <optional>
#include <utility>

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

// Exif is a TIFF: byte order, 42, the offset of the first directory; there the number of entries
// and entries of 12 bytes (tag, type, count, value). Orientation is 0x0112 with two bytes of value.
std::optional<int> tiff_orientation(std::string_view tiff) {
  if (!tiff.starts_with("II"sv) && !tiff.starts_with("MM"sv)) return std::nullopt;
  const bool big_endian = tiff.front() == 'M';
  const auto directory = number_at(tiff, 4, 4, big_endian);
  const auto two = [&](std::size_t at) { return number_at(tiff, at, 2, big_endian); };
  if (two(2) != 42U || !directory) return std::nullopt;
  const std::size_t count = two(*directory).value_or(0);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = *directory + 2 + 12 * i;
    const auto tag = two(entry);
    if (!tag) return std::nullopt;
    if (*tag != 0x0112) continue;
    const std::uint64_t value = two(entry + 8).value_or(0);
    return value >= 1 && value <= 8 ? std::optional<int>(static_cast<int>(value)) : std::nullopt;
  }
  return std::nullopt;
}

// A segment has 0xff, a marker and a length of two bytes that includes itself; the picture begins
// with the marker 0xda.
std::optional<int> find_in_jpeg(std::string_view bytes) {
  for (std::size_t at = 2; at + 4 <= bytes.size();) {
    if (bytes[at] != '\xff') return std::nullopt;
    const auto marker = static_cast<std::uint8_t>(bytes[at + 1]);
    if (marker == 0xff) {  // a fill byte
      ++at;
      continue;
    }
    const std::size_t length = number_at(bytes, at + 2, 2, true).value_or(0);
    if (marker == 0xda || length < 2) return std::nullopt;
    const std::string_view segment = bytes.substr(at + 4, length - 2);
    if (marker == 0xe1 && segment.starts_with("Exif\0\0"sv)) {
      return tiff_orientation(segment.substr(6));
    }
    at += 2 + length;
  }
  return std::nullopt;
}

// A chunk has a length of four bytes, a name, the data and a checksum.
std::optional<int> find_in_png(std::string_view bytes) {
  for (std::size_t at = 8; at + 8 <= bytes.size();) {
    const std::size_t length = number_at(bytes, at, 4, true).value_or(0);
    if (bytes.substr(at + 4, 4) == "eXIf"sv) return tiff_orientation(bytes.substr(at + 8, length));
    at += 12 + length;
  }
  return std::nullopt;
}

// After "RIFF", four bytes and "WEBP", a chunk has a name, a length of four bytes with the low one
// first, the data, and a zero if the length is odd. The data begin with "Exif" in some files.
std::optional<int> find_in_webp(std::string_view bytes) {
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t length = number_at(bytes, at + 4, 4, false).value_or(0);
    if (bytes.substr(at, 4) == "EXIF"sv) {
      const std::string_view exif = bytes.substr(at + 8, length);
      return tiff_orientation(exif.starts_with("Exif\0\0"sv) ? exif.substr(6) : exif);
    }
    at += 8 + length + length % 2;
  }
  return std::nullopt;
}

}  // namespace

int jpeg_orientation(std::string_view picture) { return find_in_jpeg(picture).value_or(1); }
int png_orientation(std::string_view picture) { return find_in_png(picture).value_or(1); }
int webp_orientation(std::string_view picture) { return find_in_webp(picture).value_or(1); }

template <typename T>
Image<T> upright(Image<T> stored, int orientation) {
  if (orientation <= 1) return stored;
  const int width = stored.width();
  const int height = stored.height();
  const bool swaps = swaps_sides(orientation);
  // The first stored row is the lowest one for 3 and 4, the rightmost column for 6 and 7; the first
  // stored column is the rightmost one for 2 and 3, the lowest row for 7 and 8.
  const bool row_from_end =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const bool column_from_end =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  Image<T> seen(swaps ? ImageSize{height, width} : stored.size());
  for (int y = 0; y < height; ++y) {
    const int across = row_from_end ? height - 1 - y : y;
    for (int x = 0; x < width; ++x) {
      const int along = column_from_end ? width - 1 - x : x;
      (swaps ? seen(across, along) : seen(along, across)) = stored(x, y);
    }
  }
  return seen;
}

template Image8 upright(Image8, int);
template Image16 upright(Image16, int);
template ImageRgb upright(ImageRgb, int);
template ImageRgb16 upright(ImageRgb16, int);

}  // namespace tagcal::internal
