#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>

// jpeglib.h needs size_t and FILE declared before it.
#include <jpeglib.h>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

// As in the decoder: calls that can fail are in member functions with setjmp and without local
// objects.
namespace tagcal::internal {
namespace {

// Quality (0 to 100) from which colour keeps the resolution of the picture. Source: none; chosen by
// hand: below it the size counts, as for thumbnails.
constexpr int kFullColourQuality = 90;

class JpegEncoder {
 public:
  explicit JpegEncoder(int quality) : quality_(quality) {
    jpeg_.err = jpeg_std_error(&manager_.base);
    manager_.base.error_exit = fail;
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
  struct Manager {
    jpeg_error_mgr base;  // first, so that a pointer to it is one to the manager
    std::jmp_buf jump;
    char text[JMSG_LENGTH_MAX] = "";
  };

  [[noreturn]] static void fail(j_common_ptr jpeg) {
    auto* manager = reinterpret_cast<Manager*>(jpeg->err);
    jpeg->err->format_message(jpeg, manager->text);
    std::longjmp(manager->jump, 1);
  }

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
  Manager manager_{};
  JSAMPROW row_ = nullptr;
  unsigned char* memory_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

template <typename T>
std::string encode_jpeg(const Image<T>& image, int quality) {
  return JpegEncoder(quality).encode(image.size(), kIsColour<T> ? 3 : 1,
                                     reinterpret_cast<const std::uint8_t*>(image.pixels().data()));
}

template std::string encode_jpeg(const Image8&, int);
template std::string encode_jpeg(const ImageRgb&, int);

}  // namespace tagcal::internal
