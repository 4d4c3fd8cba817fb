#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "tagcal/language.hpp"

namespace tagcal {

// Random number generator with the same numbers on every platform and standard library (splitmix64:
// Steele, Lea & Flood, OOPSLA 2014), so that equal seeds give equal bytes.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  // An independent stream for item `index` of a job, whatever the order in which items are done.
  Random(std::uint64_t seed, std::uint64_t index) : state_(seed) {
    state_ = next() ^ (index * 0xd1342543de82ef95ULL);
    next();
  }

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  // In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  // In [0, n), n > 0. (The bias of the remainder is below n / 2^64.)
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(next() % n); }

  // Standard normal (Box & Muller 1958).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  std::uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace tagcal
