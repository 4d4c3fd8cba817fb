#include <webp/decode.h>

#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {
namespace {

// WebP stores colour only, 8 bits.
class WebpDecoder : public ImageDecoder {
 public:
  explicit WebpDecoder(std::string_view bytes) : bytes_(bytes) {
    WebPBitstreamFeatures features;
    const bool known = WebPGetFeatures(data(), bytes.size(), &features) == VP8_STATUS_OK;
    if (!known || bytes.size() < 8 + riff_size()) throw failure();
    if (features.has_animation) throw Error("WebP: is an animation, not a picture");
    check_picture_size(features.width, features.height, bytes.size());
    header_.width = features.width;
    header_.height = features.height;
    header_.channels = 3;
    header_.orientation = webp_orientation(bytes);
  }

  void decode(const RowSink& sink) override {
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(header_.width);
    std::vector<std::uint8_t> pixels(row_bytes * static_cast<std::size_t>(header_.height));
    if (!WebPDecodeRGBInto(data(), bytes_.size(), pixels.data(), pixels.size(),
                           static_cast<int>(row_bytes))) {
      throw failure();
    }
    std::vector<std::uint16_t> row;
    for (int y = 0; y < header_.height; ++y) {
      const std::uint8_t* from = pixels.data() + static_cast<std::size_t>(y) * row_bytes;
      row.assign(from, from + row_bytes);
      sink(y, row.data());
    }
  }

 private:
  static Error failure() { return Error("WebP: is damaged or truncated"); }

  const std::uint8_t* data() const { return reinterpret_cast<const std::uint8_t*>(bytes_.data()); }

  // The number of bytes after it, as bytes 4 to 7 say.
  std::size_t riff_size() const {
    return data()[4] + 256UL * data()[5] + 65536UL * data()[6] + 16777216UL * data()[7];
  }

  std::string_view bytes_;
};

}  // namespace

std::unique_ptr<ImageDecoder> webp_decoder(std::string_view bytes) {
  return std::make_unique<WebpDecoder>(bytes);
}

}  // namespace tagcal::internal
