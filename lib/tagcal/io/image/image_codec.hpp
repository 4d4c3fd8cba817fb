#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/image.hpp"

// Private to io: the picture formats behind one interface. All functions throw Error without the
// file's name; image_file.cpp adds it.
namespace tagcal::internal {

// A picture in memory, after its header was read.
class ImageDecoder {
 public:
  struct Header {
    int width = 0;
    int height = 0;
    bool sixteen_bit = false;
    int white = 255;  // the value of white, unless the values are 16-bit
  };
  using RowSink = std::function<void(int y, const std::uint16_t* row)>;

  virtual ~ImageDecoder() = default;
  virtual Header header() const = 0;

  // Passes on the rows from the top, as grey. Call it once, after a check of the size: memory in
  // proportion to the size is allocated here only.
  virtual void decode(const RowSink& sink) = 0;
};

// `bytes` must live as long as the decoder.
std::unique_ptr<ImageDecoder> png_decoder(std::string_view bytes);
std::unique_ptr<ImageDecoder> jpeg_decoder(std::string_view bytes);

// A resolution above 0 is written into the file.
std::string encode_png(const Image8& image, double pixels_per_inch);
std::string encode_png(const Image16& image, double pixels_per_inch);
std::string encode_png(const ImageRgb& image, double pixels_per_inch);

}  // namespace tagcal::internal
