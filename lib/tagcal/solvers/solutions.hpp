#pragma once

#include <cassert>
#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>

#include "tagcal/language.hpp"

namespace tagcal {

// The solutions of a solver: zero to N, without heap. Unused elements are not constructed or
// copied.
template <typename T, std::size_t N>
class Solutions {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  Solutions() {}
  Solutions(const Solutions& other) { *this = other; }
  Solutions& operator=(const Solutions& other) {
    if (this == &other) return *this;
    size_ = 0;
    for (const T& value : other) push_back(value);
    return *this;
  }
  ~Solutions() = default;

  void push_back(const T& solution) {
    assert(size_ < N);
    new (values_ + size_++) T(solution);
  }
  // Inserts in the order of `before`; drops the last element if there is no room.
  template <typename Before>
  void insert(const T& solution, Before before) {
    if (size_ < N)
      push_back(solution);
    else if (before(solution, values_[N - 1]))
      values_[N - 1] = solution;
    for (std::size_t i = size_ - 1; i > 0 && before(values_[i], values_[i - 1]); --i)
      std::swap(values_[i], values_[i - 1]);
  }
  void pop_back() { --size_; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == N; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  const T& front() const { return values_[0]; }
  T* begin() { return values_; }
  T* end() { return values_ + size_; }
  const T* begin() const { return values_; }
  const T* end() const { return values_ + size_; }

 private:
  union {
    T values_[N];
  };
  std::size_t size_ = 0;
};

}  // namespace tagcal
