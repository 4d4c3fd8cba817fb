#include "tagcal/io/image/image_codec.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace tagcal::internal {
namespace {

Image8 scaled(const ImageView16& image, int white) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y) {
    const std::uint16_t* in = image.row(y);
    std::transform(in, in + image.width(), result.row(y), [&](int value) {
      return static_cast<std::uint8_t>(std::min(255, (value * 255 + white / 2) / white));
    });
  }
  return result;
}

// The 16-bit value that becomes white. Sensors of 10 to 14 bits store unscaled values, and files do
// not say so: white is the brightest pixel, but at most twice the 99.9 % quantile, which excludes a
// lamp or a hot pixel in a dark picture.
int white_of(const ImageView16& image) {
  std::vector<std::uint32_t> count(65536, 0);
  for (int y = 0; y < image.height(); ++y)
    for (const std::uint16_t value : std::span(image.row(y), image.row(y) + image.width()))
      ++count[value];
  const std::size_t num_pixels = static_cast<std::size_t>(image.width()) * image.height();
  int brightest = 0;
  for (int value = 65535; value > 0 && brightest == 0; --value)
    if (count[static_cast<std::size_t>(value)] > 0) brightest = value;
  std::size_t above = 0;
  int usual = brightest;
  while (usual > 0 && (above += count[static_cast<std::size_t>(usual)]) <= num_pixels / 1000)
    --usual;
  return std::clamp(2 * usual, 1, std::max(1, brightest));
}

}  // namespace

Image8 scaled_by_brightest(const ImageView16& image) { return scaled(image, white_of(image)); }

namespace {

Image8 grey8_as_stored(ImageDecoder& decoder) {
  const ImageDecoder::Header& header = decoder.header();
  const ImageSize size{header.width, header.height};
  if (!header.sixteen_bit && header.white == 255) {
    Image8 image(size);
    decoder.decode_grey([&](int y, const std::uint16_t* row) {
      std::transform(row, row + size.width, image.row(y),
                     [](std::uint16_t value) { return static_cast<std::uint8_t>(value); });
    });
    return image;
  }
  Image16 image(size);
  decoder.decode_grey(
      [&](int y, const std::uint16_t* row) { std::copy_n(row, size.width, image.row(y)); });
  return header.sixteen_bit ? scaled_by_brightest(image) : scaled(image, header.white);
}

// Values as stored; those of fewer than 8 bits are scaled to 255.
template <typename T>
Picture decode_as_stored(ImageDecoder& decoder) {
  const ImageDecoder::Header& header = decoder.header();
  const int white = header.white;
  const bool as_is = header.sixteen_bit || white == 255;
  const auto stored = [&](int value) { return as_is ? value : (value * 255 + white / 2) / white; };
  Image<T> image({header.width, header.height});
  decoder.decode([&](int y, const std::uint16_t* row) {
    for (int x = 0; x < header.width; ++x) {
      if constexpr (kIsColour<T>) {
        for (auto& value : image(x, y)) value = static_cast<typename T::value_type>(stored(*row++));
      } else {
        image(x, y) = static_cast<T>(stored(*row++));
      }
    }
  });
  return upright(std::move(image), header.orientation);
}

}  // namespace

Image8 decode_grey8(ImageDecoder& decoder) {
  return upright(grey8_as_stored(decoder), decoder.header().orientation);
}

Picture decode_picture(ImageDecoder& decoder) {
  const ImageDecoder::Header& header = decoder.header();
  if (header.sixteen_bit) {
    return header.channels == 1 ? decode_as_stored<std::uint16_t>(decoder)
                                : decode_as_stored<Rgb16>(decoder);
  }
  return header.channels == 1 ? decode_as_stored<std::uint8_t>(decoder)
                              : decode_as_stored<Rgb>(decoder);
}

}  // namespace tagcal::internal
