// stb_image with its reader of BMP alone, and without names that others could link to.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_BMP
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_NO_HDR
#define STBI_NO_FAILURE_STRINGS
#include <stb/stb_image.h>

#include <cstdlib>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {
namespace {

// stb_image reads zeros behind the end of a file: the header is read here too, so that a truncated
// file is an error, and greys are told from colours. A header has the file's size, two zeros and
// the pixels' offset, from byte 14 its own size, the picture's size, planes, bits and compression.
class BmpDecoder : public ImageDecoder {
 public:
  explicit BmpDecoder(std::string_view bytes) : bytes_(bytes) {
    if (bytes.size() < 26) throw Error("BMP: is truncated");
    const bool old = number(14, 4) == 12;  // with a size of 16 bits
    if (!old && bytes.size() < 54) throw Error("BMP: is truncated");
    const auto width = static_cast<std::int32_t>(old ? number(18, 2) : number(18, 4));
    const auto height = static_cast<std::int32_t>(old ? number(20, 2) : number(22, 4));
    const std::int64_t rows = std::abs(std::int64_t{height});  // above 0: from the lowest
    check_picture_size(width, rows, bytes.size());
    const std::int64_t bits = number(old ? 24 : 28, 2);
    const std::uint32_t compression = old ? 0 : number(30, 4);
    if (compression != 0 && compression != 3 && compression != 6)
      throw Error("BMP: is compressed, which is not read: write it without compression");
    const std::int64_t row_bytes = (bits * width + 31) / 32 * 4;
    if (static_cast<std::int64_t>(bytes.size()) < number(10, 4) + rows * row_bytes)
      throw Error("BMP: is truncated");
    header_.width = width;
    header_.height = static_cast<int>(rows);
    header_.channels = bits <= 8 && has_grey_palette(old) ? 1 : 3;
  }

  void decode(const RowSink& sink) override {
    int width = 0, height = 0, stored_channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&std::free)> pixels(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes_.data()),
                              static_cast<int>(bytes_.size()), &width, &height, &stored_channels,
                              3),
        std::free);
    if (!pixels || width != header_.width || height != header_.height)
      throw Error("BMP: is damaged, or of an unusual kind: convert it to PNG");
    std::vector<std::uint16_t> row(static_cast<std::size_t>(width * header_.channels));
    const stbi_uc* from = pixels.get();
    const int step = header_.channels == 1 ? 3 : 1;
    for (int y = 0; y < height; ++y) {
      for (std::uint16_t& value : row) {
        value = *from;
        from += step;
      }
      sink(y, row.data());
    }
  }

 private:
  // The low byte first.
  std::uint32_t number(std::size_t at, std::size_t count) const {
    return static_cast<std::uint32_t>(*number_at(bytes_, at, count, false));
  }

  // The palette stands between the header and the pixels, blue, green, red and (unless old) a zero.
  bool has_grey_palette(bool old) const {
    const std::size_t step = old ? 3 : 4;
    const std::size_t end = std::min<std::size_t>(number(10, 4), bytes_.size());
    for (std::size_t at = std::size_t{14} + number(14, 4); at + step <= end; at += step)
      if (bytes_[at] != bytes_[at + 1] || bytes_[at] != bytes_[at + 2]) return false;
    return true;
  }

  std::string_view bytes_;
};

}  // namespace

std::unique_ptr<ImageDecoder> bmp_decoder(std::string_view bytes) {
  return std::make_unique<BmpDecoder>(bytes);
}

}  // namespace tagcal::internal
