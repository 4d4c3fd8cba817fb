#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/image/image_orientation.hpp"

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
  explicit PngDecoder(std::string_view bytes) : rest_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message_, keep_error, ignore_warning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_ || !read_header()) throw failure();
    check_picture_size(header_.width, header_.height, bytes.size());
    header_.orientation = png_orientation(bytes);
  }

  void decode(const RowSink& sink) override {
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

 private:
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
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::size_t at = channels == 1 ? i * stored_channels_ : i;
      values_[i] = header_.sixteen_bit
                       ? static_cast<std::uint16_t>(row[2 * at] * 256U + row[2 * at + 1])
                       : row[at];
    }
    sink(y, values_.data());
  }

  std::string_view rest_;
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
