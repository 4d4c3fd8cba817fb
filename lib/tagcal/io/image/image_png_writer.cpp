#include <libdeflate.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {
namespace {

// The lowest level: higher ones take twice the time, and do not make noise smaller.
constexpr int kLevel = 1;

void append_number(std::uint32_t number, std::string& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
}

void append_chunk(const std::string& type, const std::string& data, std::string& png) {
  append_number(static_cast<std::uint32_t>(data.size()), png);
  const std::size_t checked = png.size();
  png += type;
  png += data;
  append_number(libdeflate_crc32(0, png.data() + checked, png.size() - checked), png);
}

// Every row after a zero, which says that it is stored as it is: filters do not make noise smaller
// either, and runs and repeated rows are found without them. The high byte of a value comes first.
template <typename T>
std::string rows_of(const Image<T>& image) {
  const std::size_t row_bytes = static_cast<std::size_t>(image.width()) * sizeof(T);
  std::string rows(static_cast<std::size_t>(image.height()) * (1 + row_bytes), '\0');
  char* out = rows.data();
  for (int y = 0; y < image.height(); ++y, out += row_bytes) {
    std::memcpy(++out, image.row(y), row_bytes);
    if constexpr (kIsSixteenBit<T> && std::endian::native == std::endian::little)
      for (std::size_t i = 0; i < row_bytes; i += 2) std::swap(out[i], out[i + 1]);
  }
  return rows;
}

std::string compressed(const std::string& data) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string result(libdeflate_zlib_compress_bound(compressor.get(), data.size()), '\0');
  result.resize(libdeflate_zlib_compress(compressor.get(), data.data(), data.size(), result.data(),
                                         result.size()));
  return result;
}

}  // namespace

template <typename T>
std::string encode_png(const Image<T>& image, double pixels_per_inch) {
  std::string header, png = "\x89PNG\r\n\x1a\n";
  append_number(static_cast<std::uint32_t>(image.width()), header);
  append_number(static_cast<std::uint32_t>(image.height()), header);
  header += kIsSixteenBit<T> ? '\x10' : '\x08';              // bits of a value
  header += kIsColour<T> ? '\x02' : '\0';                    // colour or grey
  append_chunk("IHDR", header + std::string(3, '\0'), png);  // not interlaced
  const auto pixels_per_m = static_cast<std::uint32_t>(std::lround(pixels_per_inch / 0.0254));
  if (pixels_per_m > 0) {
    std::string resolution;
    for (int axis = 0; axis < 2; ++axis) append_number(pixels_per_m, resolution);
    append_chunk("pHYs", resolution + '\1', png);
  }
  append_chunk("IDAT", compressed(rows_of(image)), png);
  append_chunk("IEND", "", png);
  return png;
}

template std::string encode_png(const Image8&, double);
template std::string encode_png(const Image16&, double);
template std::string encode_png(const ImageRgb&, double);
template std::string encode_png(const ImageRgb16&, double);

}  // namespace tagcal::internal
