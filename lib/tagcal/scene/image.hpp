#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
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

using Image8 = Image<std::uint8_t>;
using Image16 = Image<std::uint16_t>;
using ImageF = Image<float>;

using Rgb = std::array<std::uint8_t, 3>;
using ImageRgb = Image<Rgb>;

}  // namespace tagcal
