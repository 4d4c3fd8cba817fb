#include "tagcal/detect/image_filters.hpp"

#include <algorithm>

namespace tagcal {
namespace {

// Loops that compilers turn into a few vector instructions.
void raise_to(const std::uint8_t* in, int count, std::uint8_t* out) {
  for (int x = 0; x < count; ++x) out[x] = std::max(out[x], in[x]);
}

}  // namespace

Image8 brightest(const Image8& image, int radius) {
  const int width = image.width(), height = image.height();
  Image8 rows = image;
  for (int y = 0; y < height; ++y) {
    for (int shift = 1; shift <= std::min(radius, width - 1); ++shift) {
      raise_to(image.row(y) + shift, width - shift, rows.row(y));
      raise_to(image.row(y), width - shift, rows.row(y) + shift);
    }
  }
  Image8 result = rows;
  for (int y = 0; y < height; ++y) {
    for (int i = std::max(0, y - radius); i <= std::min(height - 1, y + radius); ++i)
      if (i != y) raise_to(rows.row(i), width, result.row(y));
  }
  return result;
}

Image8 halved(const Image8& image) {
  Image8 result({image.width() / 2, image.height() / 2});
  for (int y = 0; y < result.height(); ++y) {
    const std::uint8_t* above = image.row(2 * y);
    const std::uint8_t* below = image.row(2 * y + 1);
    std::uint8_t* out = result.row(y);
    for (int x = 0; x < result.width(); ++x) {
      const int sum = above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1];
      out[x] = static_cast<std::uint8_t>((sum + 2) / 4);
    }
  }
  return result;
}

Image8 part_of(const Image8& image, const PixelBox& box) {
  Image8 result(box.size);
  for (int y = 0; y < box.size.height; ++y)
    std::copy_n(image.row(box.top + y) + box.left, box.size.width, result.row(y));
  return result;
}

}  // namespace tagcal
