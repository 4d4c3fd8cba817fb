#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {
namespace {

// The pixels of a pass: from (x, y) on, every dx-th and dy-th.
struct PngPass {
  int x, y, dx, dy;
};
constexpr PngPass kWhole[] = {{0, 0, 1, 1}};
constexpr PngPass kInterlaced[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                   {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};  // Adam7

enum PngColour { kGrey = 0, kRgb = 2, kPalette = 3, kGreyAlpha = 4, kRgba = 6 };

std::uint16_t luma(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return static_cast<std::uint16_t>((299 * red + 587 * green + 114 * blue + 500) / 1000);
}

// The neighbour nearest to left + above - corner.
int paeth(int left, int above, int corner) {
  const int by_left = std::abs(above - corner), by_above = std::abs(left - corner);
  const int by_corner = std::abs(left + above - 2 * corner);
  if (by_left <= by_above && by_left <= by_corner) return left;
  return by_above <= by_corner ? above : corner;
}

// Undoes the filter of a row; `step` bytes lie between a byte and its left neighbour.
void unfilter(int filter, std::size_t step, const std::uint8_t* above, std::uint8_t* row,
              std::size_t size) {
  const auto undo = [&](const auto& guess) {
    for (std::size_t i = 0; i < size; ++i) {
      const int left = i < step ? 0 : row[i - step], corner = i < step ? 0 : above[i - step];
      row[i] = static_cast<std::uint8_t>(row[i] + guess(left, above[i], corner));
    }
  };
  if (filter == 1) undo([](int left, int, int) { return left; });
  if (filter == 2) undo([](int, int up, int) { return up; });
  if (filter == 3) undo([](int left, int up, int) { return (left + up) / 2; });
  if (filter == 4) undo(paeth);
  if (filter > 4) throw Error("PNG: a row has an unknown filter");
}

// By the PNG specification (W3C, second edition). All memory but the header's is taken in decode().
class PngDecoder : public ImageDecoder {
 public:
  explicit PngDecoder(std::string_view bytes) : rest_(bytes.substr(8)) {
    const auto [type, data] = next_chunk();
    if (type != "IHDR" || data.size() != 13) throw Error("PNG: has no header");
    const auto byte = [&data = data](std::size_t i) { return static_cast<std::uint8_t>(data[i]); };
    header_.width = static_cast<int>(number(data) & 0x7fffffff);
    header_.height = static_cast<int>(number(data.substr(4)) & 0x7fffffff);
    bits_ = byte(8);
    colour_ = byte(9);
    is_interlaced_ = byte(12) == 1;
    header_.sixteen_bit = bits_ == 16;
    const bool is_one = colour_ == kGrey || colour_ == kPalette;
    const bool is_known = is_one || colour_ == kRgb || colour_ == kGreyAlpha || colour_ == kRgba;
    const bool has_bits = bits_ == 8 || (bits_ == 16 && colour_ != kPalette) ||
                          (is_one && (bits_ == 1 || bits_ == 2 || bits_ == 4));
    if (!is_known || !has_bits || byte(10) != 0 || byte(11) != 0 || byte(12) > 1)
      throw Error("PNG: has an unknown kind of pixels");
    channels_ = is_one ? 1 : colour_ == kGreyAlpha ? 2 : colour_ == kRgb ? 3 : 4;
    for (std::size_t i = 0; colour_ == kGrey && bits_ <= 8 && i < 1U << bits_; ++i)
      grey_of_[i] = static_cast<std::uint16_t>(i * 255 / ((1U << bits_) - 1));
  }

  Header header() const override { return header_; }

  void decode(const RowSink& sink) override {
    std::vector<std::uint8_t> bytes = inflated();
    const auto width = static_cast<std::size_t>(header_.width);
    const auto height = static_cast<std::size_t>(header_.height);
    // An interlaced picture is complete only after the last pass.
    std::vector<std::uint16_t> grey(is_interlaced_ ? width * height : width);
    const auto row_of = [&](int y) {
      return grey.data() + (is_interlaced_ ? static_cast<std::size_t>(y) * width : 0);
    };
    std::uint8_t* row = bytes.data();
    for (const PngPass& pass : passes()) {
      const std::size_t size = row_bytes(pass);
      const std::vector<std::uint8_t> nothing(size, 0);
      const std::uint8_t* above = nothing.data();
      for (int y = pass.y; size > 0 && y < header_.height; y += pass.dy, row += size) {
        const int filter = *row++;
        unfilter(filter, std::max<std::size_t>(1, bits_per_pixel() / 8), above, row, size);
        above = row;
        put_grey(row, pass, row_of(y));
        if (!is_interlaced_) sink(y, row_of(y));
      }
    }
    for (int y = 0; is_interlaced_ && y < header_.height; ++y) sink(y, row_of(y));
  }

 private:
  static std::uint32_t number(std::string_view bytes) {
    std::uint32_t result = 0;
    for (const char byte : bytes.substr(0, 4))
      result = result << 8 | static_cast<std::uint8_t>(byte);
    return result;
  }

  // Type and data of the next chunk. Those that a picture needs are checked.
  std::pair<std::string_view, std::string_view> next_chunk() {
    constexpr std::size_t kAround = 12;  // bytes: size, type and checksum
    const std::size_t size = rest_.size() < kAround ? 0 : number(rest_);
    if (rest_.size() < kAround + size) throw Error("PNG: is truncated");
    const std::string_view checked = rest_.substr(4, 4 + size);
    const bool is_needed = (checked[0] & 0x20) == 0;  // a capital letter
    if (is_needed && libdeflate_crc32(0, checked.data(), checked.size()) !=
                         number(rest_.substr(kAround - 4 + size)))
      throw Error("PNG: a checksum is wrong");
    rest_.remove_prefix(kAround + size);
    return {checked.substr(0, 4), checked.substr(4)};
  }

  std::span<const PngPass> passes() const {
    return is_interlaced_ ? std::span<const PngPass>(kInterlaced) : kWhole;
  }
  std::size_t bits_per_pixel() const { return static_cast<std::size_t>(channels_ * bits_); }
  // Bytes of a row without that of its filter.
  std::size_t row_bytes(const PngPass& pass) const {
    const int pixels = std::max(0, (header_.width - pass.x + pass.dx - 1) / pass.dx);
    return (static_cast<std::size_t>(pixels) * bits_per_pixel() + 7) / 8;
  }

  // All rows, each after its filter, pass by pass.
  std::vector<std::uint8_t> inflated() {
    std::string packed;
    bool has_palette = colour_ != kPalette;
    for (bool is_end = false; !is_end;) {
      const auto [type, data] = next_chunk();
      if (type == "IDAT") packed += data;
      if (type == "PLTE") has_palette = true, set_palette(data);
      is_end = type == "IEND";
    }
    if (!has_palette) throw Error("PNG: has no palette");
    std::size_t size = 0;
    for (const PngPass& pass : passes()) {
      const int rows = std::max(0, (header_.height - pass.y + pass.dy - 1) / pass.dy);
      if (row_bytes(pass) > 0) size += static_cast<std::size_t>(rows) * (1 + row_bytes(pass));
    }
    constexpr std::size_t kMostTimes = 1032;  // by which deflate shrinks, at most
    if (size / kMostTimes > packed.size()) throw Error("PNG: is truncated");
    std::vector<std::uint8_t> bytes(size);
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        inflater(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (!inflater) throw std::bad_alloc();
    if (libdeflate_zlib_decompress(inflater.get(), packed.data(), packed.size(), bytes.data(), size,
                                   nullptr) != LIBDEFLATE_SUCCESS)
      throw Error("PNG: the pixels cannot be decompressed");
    return bytes;
  }

  void set_palette(std::string_view data) {
    if (colour_ != kPalette) return;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(data[i]); };
    for (std::size_t i = 0; i < grey_of_.size() && 3 * i + 2 < data.size(); ++i)
      grey_of_[i] = luma(byte(3 * i), byte(3 * i + 1), byte(3 * i + 2));
  }

  // Grey by Rec. 601 luma of the stored values: the file's gamma is not applied, nor its alpha.
  void put_grey(const std::uint8_t* row, const PngPass& pass, std::uint16_t* grey) const {
    const auto put = [&](const auto& value) {
      std::size_t i = 0;
      for (int x = pass.x; x < header_.width; x += pass.dx) grey[x] = value(i++);
    };
    const auto n = static_cast<std::size_t>(channels_), bits = static_cast<std::size_t>(bits_);
    const auto word = [&](std::size_t i) {
      return static_cast<std::uint16_t>(row[2 * i] << 8 | row[2 * i + 1]);
    };
    if (n >= 3 && bits == 16) {
      put([&](std::size_t i) { return luma(word(n * i), word(n * i + 1), word(n * i + 2)); });
    } else if (n >= 3) {
      put([&](std::size_t i) { return luma(row[n * i], row[n * i + 1], row[n * i + 2]); });
    } else if (bits == 16) {
      put([&](std::size_t i) { return word(n * i); });
    } else if (bits == 8 && colour_ != kPalette) {
      put([&](std::size_t i) { return row[n * i]; });
    } else {
      put([&](std::size_t i) {
        return grey_of_[row[i * bits / 8] >> (8 - bits - i * bits % 8) & ((1U << bits) - 1)];
      });
    }
  }

  std::string_view rest_;
  Header header_;
  int bits_ = 8, colour_ = kGrey, channels_ = 1;
  bool is_interlaced_ = false;
  std::array<std::uint16_t, 256> grey_of_{};  // of a palette's colours, or of few bits
};

}  // namespace

std::unique_ptr<ImageDecoder> png_decoder(std::string_view bytes) {
  return std::make_unique<PngDecoder>(bytes);
}

}  // namespace tagcal::internal
