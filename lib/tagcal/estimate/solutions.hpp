#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <utility>

namespace tagcal {

// What a solver found: none or up to N, kept without the heap.
template <typename T, std::size_t N>
class Solutions {
 public:
  static constexpr std::size_t kCapacity = N;

  void push_back(const T& solution) {
    assert(size_ < N);
    values_[size_++] = solution;
  }
  // Keeps the order of `before`; the last one falls out where there is no room.
  template <typename Before>
  void insert(const T& solution, Before before) {
    if (size_ < N)
      values_[size_++] = solution;
    else if (before(solution, values_[N - 1]))
      values_[N - 1] = solution;
    for (std::size_t i = size_ - 1; i > 0 && before(values_[i], values_[i - 1]); --i)
      std::swap(values_[i], values_[i - 1]);
  }
  void pop_back() { --size_; }
  void clear() { size_ = 0; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == N; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  const T& front() const { return values_[0]; }
  T* begin() { return values_.data(); }
  T* end() { return values_.data() + size_; }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }

 private:
  std::array<T, N> values_;
  std::size_t size_ = 0;
};

}  // namespace tagcal
