#include <libdeflate.h>
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

// libpng reports errors by longjmp. It is only called in member functions with setjmp and without
// local objects, so that a jump skips no destructor; a member keeps the message.
namespace tagcal::internal {
namespace {

struct PngMessage {
  char text[200] = "";
};

void keep_error(png_structp png, png_const_charp message) {
  auto* kept = static_cast<PngMessage*>(png_get_error_ptr(png));
  std::strncpy(kept->text, message, sizeof(kept->text) - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// The data of the IDAT chunks. Empty if they do not follow one another, are damaged, or the file
// does not end after them as it should.
std::string deflated_pixels(std::string_view png) {
  constexpr std::size_t kSignature = 8, kFrame = 12;  // bytes; of a chunk: length, type, check sum
  std::string pixels;
  pixels.reserve(png.size());
  bool is_complete = false;
  for (png.remove_prefix(kSignature); png.size() >= kFrame;) {
    const std::size_t size = *number_at(png, 0, 4, true);
    if (size > png.size() - kFrame) break;
    const std::string_view checked = png.substr(4, 4 + size);
    if (checked.starts_with("IEND")) return pixels;
    if (!checked.starts_with("IDAT")) {
      is_complete = !pixels.empty();
    } else {
      if (is_complete ||
          libdeflate_crc32(0, checked.data(), checked.size()) != number_at(png, 8 + size, 4, true))
        break;
      pixels += checked.substr(4);
    }
    png.remove_prefix(kFrame + size);
  }
  return {};
}

bool inflate_into(png_byte* rows, std::size_t size, const std::string& deflated) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  return inflater && libdeflate_zlib_decompress(inflater.get(), deflated.data(), deflated.size(),
                                                rows, size, nullptr) == LIBDEFLATE_SUCCESS;
}

// Adds to each byte of a row what its filter predicts from the bytes to the left, above, and above
// to the left (PNG specification, 9.2). False for a filter that does not exist.
bool undo_filter(int filter, std::size_t row_bytes, std::size_t pixel_bytes, const png_byte* above,
                 png_byte* row) {
  const auto add = [&](const auto& predicted) {
    for (std::size_t i = 0; i < row_bytes; ++i) {
      const bool is_first = i < pixel_bytes;
      row[i] =
          static_cast<png_byte>(row[i] + predicted(is_first ? 0 : row[i - pixel_bytes], above[i],
                                                   is_first ? 0 : above[i - pixel_bytes]));
    }
    return true;
  };
  switch (filter) {
    case PNG_FILTER_VALUE_NONE:
      return true;
    case PNG_FILTER_VALUE_SUB:
      return add([](int left, int, int) { return left; });
    case PNG_FILTER_VALUE_UP:
      return add([](int, int up, int) { return up; });
    case PNG_FILTER_VALUE_AVG:
      return add([](int left, int up, int) { return (left + up) / 2; });
    case PNG_FILTER_VALUE_PAETH:
      return add([](int left, int up, int corner) {
        const int a = std::abs(up - corner), b = std::abs(left - corner);
        const int c = std::abs(left + up - 2 * corner);
        return a <= b && a <= c ? left : b <= c ? up : corner;
      });
    default:
      return false;
  }
}

// A base class, so that it is destroyed if the constructor of the decoder throws.
struct PngReader {
  PngReader() = default;
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

class PngDecoder : public ImageDecoder, private PngReader {
 public:
  explicit PngDecoder(std::string_view bytes) : bytes_(bytes), rest_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message_, keep_error, ignore_warning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_ || !read_header()) throw failure();
    check_picture_size(header_.width, header_.height, bytes.size());
    header_.orientation = png_orientation(bytes);
  }

  void decode(const RowSink& sink) override {
    if (!decode_at_once(sink)) decode_by_rows(sink);
  }

 private:
  // Pictures of the usual kinds: libdeflate inflates them in less than half of zlib's time. False,
  // without a row, for others and for damaged ones, for which libpng says what is wrong.
  bool decode_at_once(const RowSink& sink) {
    constexpr std::size_t kMostBytes = 1U << 26;  // as a limit of memory
    const int colour = png_get_color_type(png_, info_);
    if (png_get_bit_depth(png_, info_) < 8 ||
        (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_RGB) ||
        png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE)
      return false;
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    const auto height = static_cast<std::size_t>(header_.height);
    if (row_bytes * height > kMostBytes) return false;
    const std::size_t size = (1 + row_bytes) * height;  // each row after the number of its filter
    const auto rows = std::make_unique_for_overwrite<png_byte[]>(size);
    if (!inflate_into(rows.get(), size, deflated_pixels(bytes_))) return false;
    pixels_.assign(row_bytes, 0);
    const png_byte* above = pixels_.data();
    const std::size_t pixel_bytes = row_bytes / static_cast<std::size_t>(header_.width);
    for (png_byte* row = rows.get(); row != rows.get() + size; row += 1 + row_bytes) {
      if (!undo_filter(*row, row_bytes, pixel_bytes, above, row + 1)) return false;
      above = row + 1;
    }
    values_.resize(static_cast<std::size_t>(header_.width * header_.channels));
    for (std::size_t y = 0; y < height; ++y)
      emit(sink, static_cast<int>(y), rows.get() + y * (1 + row_bytes) + 1);
    return true;
  }

  void decode_by_rows(const RowSink& sink) {
    if (!set_transforms()) throw failure();
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    const auto height = static_cast<std::size_t>(header_.height);
    // An interlaced picture is complete only after the last pass; others need memory for one row.
    pixels_.assign(row_bytes * (passes_ > 1 ? height : 1), 0);
    values_.resize(static_cast<std::size_t>(header_.width * header_.channels));
    for (int y = 0; passes_ == 1 && y < header_.height; ++y) {
      if (!read_row()) throw failure();
      emit(sink, y, pixels_.data());
    }
    if (passes_ > 1) {
      for (std::size_t y = 0; y < height; ++y) rows_.push_back(pixels_.data() + y * row_bytes);
      if (!read_all()) throw failure();
      for (int y = 0; y < header_.height; ++y) emit(sink, y, rows_[static_cast<std::size_t>(y)]);
    }
    if (!read_end()) throw failure();
  }

  static void next_bytes(png_structp png, png_bytep out, std::size_t count) {
    auto* self = static_cast<PngDecoder*>(png_get_io_ptr(png));
    if (count > self->rest_.size()) png_error(png, "is truncated");
    std::memcpy(out, self->rest_.data(), count);
    self->rest_.remove_prefix(count);
  }

  Error failure() const {
    return Error(message_.text[0] ? std::string("PNG: ") + message_.text : "PNG: cannot be read");
  }

  bool read_header() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_read_fn(png_, this, next_bytes);
    png_set_user_limits(png_, 0x7fffffff, 0x7fffffff);  // the caller checks the size
    png_set_chunk_malloc_max(png_, 1U << 26);
    // All that is not needed for the pixels: texts and profiles may inflate to gigabytes.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    header_.width = static_cast<int>(png_get_image_width(png_, info_));
    header_.height = static_cast<int>(png_get_image_height(png_, info_));
    header_.sixteen_bit = png_get_bit_depth(png_, info_) == 16;
    const bool colour = (png_get_color_type(png_, info_) & PNG_COLOR_MASK_COLOR) != 0;
    header_.channels = colour && !has_grey_palette() ? 3 : 1;
    return true;
  }

  bool has_grey_palette() {
    png_colorp palette = nullptr;
    int count = 0;
    return png_get_PLTE(png_, info_, &palette, &count) != 0 &&
           png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE &&
           std::all_of(palette, palette + count,
                       [](const png_color& c) { return c.red == c.green && c.green == c.blue; });
  }

  bool set_transforms() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_expand(png_);  // palettes to colour, fewer than 8 bits to 8
    png_set_strip_alpha(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    stored_channels_ = png_get_channels(png_, info_);
    return true;
  }

  bool read_row() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_row(png_, pixels_.data(), nullptr);
    return true;
  }

  bool read_all() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_image(png_, rows_.data());
    return true;
  }

  bool read_end() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_end(png_, nullptr);
    return true;
  }

  void emit(const RowSink& sink, int y, const png_byte* row) {
    const auto channels = static_cast<std::size_t>(header_.channels);
    if (!header_.sixteen_bit && (channels > 1 || stored_channels_ == 1)) {
      std::copy_n(row, values_.size(), values_.begin());
      return sink(y, values_.data());
    }
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::size_t at = channels == 1 ? i * stored_channels_ : i;
      values_[i] = header_.sixteen_bit
                       ? static_cast<std::uint16_t>(row[2 * at] * 256U + row[2 * at + 1])
                       : row[at];
    }
    sink(y, values_.data());
  }

  std::string_view bytes_, rest_;  // the file, and what libpng has not read of it
  PngMessage message_;
  int passes_ = 1;
  std::size_t stored_channels_ = 1;  // 3 for a grey palette
  std::vector<png_byte> pixels_;
  std::vector<png_bytep> rows_;
  std::vector<std::uint16_t> values_;
};

}  // namespace

std::unique_ptr<ImageDecoder> png_decoder(std::string_view bytes) {
  return std::make_unique<PngDecoder>(bytes);
}

}  // namespace tagcal::internal
