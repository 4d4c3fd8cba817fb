#include <fmt/core.h>

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

// jpeglib.h needs size_t and FILE declared before it.
#include <jerror.h>
#include <jpeglib.h>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/text/limits.hpp"

// As with libpng, calls that can fail are in member functions with setjmp and without local
// objects. The library's own handlers would print and exit.
namespace tagcal::internal {
namespace {

struct JpegManager {
  jpeg_error_mgr base;  // first, so that a pointer to it is one to the manager
  std::jmp_buf jump;
  char text[JMSG_LENGTH_MAX] = "";
};

[[noreturn]] void fail_jpeg(j_common_ptr jpeg) {
  auto* manager = reinterpret_cast<JpegManager*>(jpeg->err);
  jpeg->err->format_message(jpeg, manager->text);
  std::longjmp(manager->jump, 1);
}

class JpegDecoder : public ImageDecoder {
 public:
  // `least_width` 0: at full size.
  explicit JpegDecoder(std::string_view bytes, int least_width = 0) {
    jpeg_.err = jpeg_std_error(&manager_.base);
    manager_.base.error_exit = fail_jpeg;
    manager_.base.emit_message = judge_warning;
    manager_.base.output_message = [](j_common_ptr) {};
    if (!create() || !read_header(bytes)) throw failure();
    check_picture_size(header_.width, header_.height, bytes.size());
    header_.orientation = jpeg_orientation(bytes);
    if (least_width > 0) reduce(least_width);
  }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  void decode(const RowSink& sink) override {
    if (is_of_inks()) return decode_inks(sink);
    decode_as(header_.channels == 1 ? JCS_GRAYSCALE : JCS_RGB, header_.channels, sink);
  }

  // The luma is stored as such, except in a picture of inks.
  void decode_grey(const RowSink& sink) override {
    if (is_of_inks()) return ImageDecoder::decode_grey(sink);
    decode_as(JCS_GRAYSCALE, 1, sink);
  }

 private:
  // The low frequencies of a block of 8 x 8 pixels are a smaller block, for less work than all.
  // Only whole blocks are reduced, so that the sides of the picture are divided exactly.
  void reduce(int least_width) {
    const int width = swaps_sides(header_.orientation) ? header_.height : header_.width;
    int shrink = 8;
    while (shrink > 1 && (header_.width % shrink != 0 || header_.height % shrink != 0 ||
                          width / shrink < least_width))
      shrink /= 2;
    jpeg_.scale_num = 1;
    jpeg_.scale_denom = static_cast<unsigned>(shrink);
    header_.width /= shrink;
    header_.height /= shrink;
  }

  bool is_of_inks() const {
    return jpeg_.jpeg_color_space == JCS_CMYK || jpeg_.jpeg_color_space == JCS_YCCK;
  }

  // Cyan, magenta, yellow and black to red, green and blue, each ink taken as a perfect filter.
  // Adobe's programs store the light that passes an ink instead of the ink.
  void decode_inks(const RowSink& sink) {
    std::vector<std::uint16_t> colours(3 * static_cast<std::size_t>(header_.width));
    const auto light = [this](std::uint16_t ink) {
      return jpeg_.saw_Adobe_marker ? ink : static_cast<std::uint16_t>(255 - ink);
    };
    decode_as(JCS_CMYK, 4, [&](int y, const std::uint16_t* inks) {
      for (std::size_t i = 0; i < colours.size(); ++i)
        colours[i] = static_cast<std::uint16_t>(
            (light(inks[4 * (i / 3) + i % 3]) * light(inks[4 * (i / 3) + 3]) + 127) / 255);
      sink(y, colours.data());
    });
  }

  void decode_as(J_COLOR_SPACE colours, int channels, const RowSink& sink) {
    if (!start(colours)) throw failure();
    row_.resize(static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(channels));
    for (int y = 0; y < header_.height; ++y) {
      if (!read_row()) throw failure();
      values_.assign(row_.begin(), row_.end());
      sink(y, values_.data());
    }
    if (!finish()) throw failure();
  }

  // The library fills missing parts with grey and only warns; here that is an error.
  static void judge_warning(j_common_ptr jpeg, int level) {
    if (level >= 0) return;
    const int code = jpeg->err->msg_code;
    if (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE ||
        code == JWRN_MUST_RESYNC) {
      fail_jpeg(jpeg);
    }
  }

  static void check_scans(j_common_ptr jpeg) {
    if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= limits::kMaxJpegScans)
      return;
    auto* manager = reinterpret_cast<JpegManager*>(jpeg->err);
    fmt::format_to_n(manager->text, sizeof manager->text - 1, "more than {} scans",
                     limits::kMaxJpegScans);
    std::longjmp(manager->jump, 1);
  }

  Error failure() const {
    const int code = manager_.base.msg_code;
    const bool cut = code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER;
    return Error(std::string(cut ? "JPEG: is truncated: " : "JPEG: ") + manager_.text);
  }

  bool create() {
    if (setjmp(manager_.jump)) return false;
    jpeg_create_decompress(&jpeg_);
    progress_.progress_monitor = check_scans;
    jpeg_.progress = &progress_;
    return true;
  }

  bool read_header(std::string_view bytes) {
    if (setjmp(manager_.jump)) return false;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&jpeg_, TRUE);
    header_.width = static_cast<int>(jpeg_.image_width);
    header_.height = static_cast<int>(jpeg_.image_height);
    header_.channels = jpeg_.jpeg_color_space == JCS_GRAYSCALE ? 1 : 3;
    return true;
  }

  bool start(J_COLOR_SPACE colours) {
    if (setjmp(manager_.jump)) return false;
    jpeg_.out_color_space = colours;
    jpeg_start_decompress(&jpeg_);
    return true;
  }

  bool read_row() {
    if (setjmp(manager_.jump)) return false;
    JSAMPROW row = row_.data();
    jpeg_read_scanlines(&jpeg_, &row, 1);
    return true;
  }

  bool finish() {
    if (setjmp(manager_.jump)) return false;
    jpeg_finish_decompress(&jpeg_);
    return true;
  }

  // A member frees it also where the constructor throws.
  struct Decompress : jpeg_decompress_struct {
    Decompress() : jpeg_decompress_struct{} {}
    ~Decompress() { jpeg_destroy_decompress(this); }
  };
  Decompress jpeg_;
  JpegManager manager_{};
  jpeg_progress_mgr progress_{};
  std::vector<JSAMPLE> row_;
  std::vector<std::uint16_t> values_;
};

// Quality (0 to 100) from which colour keeps the resolution of the picture. Source: ImageMagick, as
// written by its coders/jpeg.c.
constexpr int kFullColourQuality = 90;

class JpegEncoder {
 public:
  explicit JpegEncoder(int quality) : quality_(quality) {
    jpeg_.err = jpeg_std_error(&manager_.base);
    manager_.base.error_exit = fail_jpeg;
    manager_.base.output_message = [](j_common_ptr) {};
  }
  ~JpegEncoder() {
    jpeg_destroy_compress(&jpeg_);
    std::free(memory_);
  }
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  // `pixels`: `channels` values a pixel, row by row.
  std::string encode(const ImageSize& size, int channels, const std::uint8_t* pixels) {
    if (!run(size, channels, pixels)) throw Error(std::string("JPEG: ") + manager_.text);
    return {reinterpret_cast<const char*>(memory_), size_};
  }

 private:
  bool run(const ImageSize& size, int channels, const std::uint8_t* pixels) {
    if (setjmp(manager_.jump)) return false;
    jpeg_create_compress(&jpeg_);
    jpeg_mem_dest(&jpeg_, &memory_, &size_);
    jpeg_.image_width = static_cast<JDIMENSION>(size.width);
    jpeg_.image_height = static_cast<JDIMENSION>(size.height);
    jpeg_.input_components = channels;
    jpeg_.in_color_space = channels == 3 ? JCS_RGB : JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg_);
    jpeg_set_quality(&jpeg_, quality_, TRUE);
    if (quality_ >= kFullColourQuality) {
      jpeg_.comp_info[0].h_samp_factor = 1;
      jpeg_.comp_info[0].v_samp_factor = 1;
    }
    jpeg_start_compress(&jpeg_, TRUE);
    while (jpeg_.next_scanline < jpeg_.image_height) {
      row_ = const_cast<JSAMPROW>(pixels) +
             static_cast<std::size_t>(jpeg_.next_scanline) * size.width * channels;
      jpeg_write_scanlines(&jpeg_, &row_, 1);
    }
    jpeg_finish_compress(&jpeg_);
    return true;
  }

  int quality_;
  jpeg_compress_struct jpeg_{};
  JpegManager manager_{};
  JSAMPROW row_ = nullptr;
  unsigned char* memory_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

std::unique_ptr<ImageDecoder> jpeg_decoder(std::string_view bytes) {
  return std::make_unique<JpegDecoder>(bytes);
}

std::unique_ptr<ImageDecoder> reduced_jpeg_decoder(std::string_view bytes, int least_width) {
  return std::make_unique<JpegDecoder>(bytes, least_width);
}

bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }

template <typename T>
std::string encode_jpeg(const Image<T>& image, int quality) {
  return JpegEncoder(quality).encode(image.size(), kIsColour<T> ? 3 : 1,
                                     reinterpret_cast<const std::uint8_t*>(image.pixels().data()));
}

template std::string encode_jpeg(const Image8&, int);
template std::string encode_jpeg(const ImageRgb&, int);

}  // namespace tagcal::internal
