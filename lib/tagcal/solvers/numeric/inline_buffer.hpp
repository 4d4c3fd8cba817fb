#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tagcal::internal {

// An array whose size is known at run time: up to N elements without heap.
template <typename T, std::size_t N>
class InlineBuffer {
 public:
  explicit InlineBuffer(std::size_t size) : size_(size) {
    if (size > N) many_.resize(size);
  }

  std::size_t size() const { return size_; }
  T* data() { return size_ > N ? many_.data() : few_.data(); }
  const T* data() const { return size_ > N ? many_.data() : few_.data(); }
  T& operator[](std::size_t i) { return data()[i]; }
  const T& operator[](std::size_t i) const { return data()[i]; }
  std::span<const T> span() const { return {data(), size_}; }

 private:
  std::size_t size_;
  std::array<T, N> few_;
  std::vector<T> many_;
};

}  // namespace tagcal::internal
