#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/scene/raster/noise.hpp"

namespace tagcal {
using namespace internal;
namespace {

double cumulative(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

class Noise : public testing::Test {
 protected:
  static constexpr int kCount = 1'000'000;

  Noise() {
    NormalNoise noise(Random(5, 1));
    for (int i = 0; i < kCount; ++i) numbers_.push_back(noise.next());
    std::ranges::sort(numbers_);
  }

  // Share of the numbers above x.
  double above(double x) const {
    return static_cast<double>(numbers_.end() - std::ranges::upper_bound(numbers_, x)) / kCount;
  }

  std::vector<double> numbers_;
};

// Kolmogorov's distance is above 1.95 / sqrt(n) once in 1,000 times.
TEST_F(Noise, IsNormal) {
  double distance = 0;
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    distance = std::max(
        distance, std::abs((static_cast<double>(i) + 0.5) / kCount - cumulative(numbers_[i])));
  EXPECT_LT(distance, 1.95 / std::sqrt(kCount));
}

TEST_F(Noise, HasTheMomentsOfANormal) {
  const double expected[] = {0, 1, 0, 3, 0, 15}, variances[] = {1, 2, 15, 96, 945, 10170};
  for (int power = 1; power <= 6; ++power) {
    double sum = 0;
    for (const double x : numbers_) {
      double product = 1;
      for (int i = 0; i < power; ++i) product *= x;
      sum += product;
    }
    EXPECT_NEAR(sum / kCount, expected[power - 1], 4 * std::sqrt(variances[power - 1] / kCount))
        << power;
  }
}

// The ziggurat ends at 3.654; beyond it another method takes over.
TEST_F(Noise, TailsAreThoseOfANormal) {
  for (const double x : {2.5, 3.0, 3.5, 3.654, 3.8, 4.2, 4.6}) {
    const double share = cumulative(-x), tolerance = 4 * std::sqrt(share / kCount);
    EXPECT_NEAR(above(x), share, tolerance) << x;
    EXPECT_NEAR(1 - above(-x), share, tolerance) << -x;
  }
}

}  // namespace
}  // namespace tagcal
