#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal {

// A picture; its rows are stored from the top.
template <typename T>
class Image {
 public:
  Image() = default;
  explicit Image(const ImageSize& size, T value = T())
      : size_(size),
        pixels_(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height),
                value) {}

  const ImageSize& size() const { return size_; }
  int width() const { return size_.width; }
  int height() const { return size_.height; }
  bool empty() const { return pixels_.empty(); }

  T* row(int y) { return pixels_.data() + static_cast<std::size_t>(y) * size_.width; }
  const T* row(int y) const { return pixels_.data() + static_cast<std::size_t>(y) * size_.width; }
  T& operator()(int x, int y) { return row(y)[x]; }
  const T& operator()(int x, int y) const { return row(y)[x]; }

  const std::vector<T>& pixels() const { return pixels_; }

 private:
  ImageSize size_;
  std::vector<T> pixels_;
};

// A picture in memory of another owner, which must outlive it: of an Image, or of a library such as
// OpenCV's cv::Mat (its data, its size, and its step in bytes divided by the size of a value).
template <typename T>
class ImageView {
 public:
  ImageView() = default;
  // The implicit conversion lets functions take both kinds.
  ImageView(const Image<T>& image)
      : ImageView(image.pixels().data(), image.size(), image.width()) {}
  // `stride` is the number of values from one row to the next, >= size.width.
  ImageView(const T* pixels, const ImageSize& size, std::ptrdiff_t stride)
      : size_(size), stride_(stride), pixels_(pixels) {
    assert(stride >= size.width);
  }

  const ImageSize& size() const { return size_; }
  int width() const { return size_.width; }
  int height() const { return size_.height; }
  std::ptrdiff_t stride() const { return stride_; }
  bool empty() const { return size_.width <= 0 || size_.height <= 0; }

  const T* row(int y) const { return pixels_ + y * stride_; }
  const T& operator()(int x, int y) const { return row(y)[x]; }

 private:
  ImageSize size_;
  std::ptrdiff_t stride_ = 0;
  const T* pixels_ = nullptr;
};

using Image8 = Image<std::uint8_t>;
using Image16 = Image<std::uint16_t>;
using ImageF = Image<float>;
using ImageView8 = ImageView<std::uint8_t>;
using ImageView16 = ImageView<std::uint16_t>;

using Rgb = std::array<std::uint8_t, 3>;
using Rgb16 = std::array<std::uint16_t, 3>;
using ImageRgb = Image<Rgb>;
using ImageRgb16 = Image<Rgb16>;

// A picture of a kind that files decide: grey or red, green, blue; 8 or 16 bits a value.
using Picture = std::variant<Image8, Image16, ImageRgb, ImageRgb16>;

inline const ImageSize& size_of(const Picture& picture) {
  return std::visit([](const auto& image) -> const ImageSize& { return image.size(); }, picture);
}

}  // namespace tagcal
