#include "tagcal/solvers/numeric/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "tagcal/random.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The probability that a standard normal variable exceeds z.
double normal_tail(double z) { return std::erfc(z / std::numbers::sqrt2) / 2; }

// Of a chi-square with an even number of degrees of freedom: exp(-y) times the first k / 2 terms of
// exp(y), with y = x / 2.
double chi_square_tail(int k, double x) {
  double term = std::exp(-x / 2), sum = 0;
  for (int i = 0; i < k / 2; ++i) {
    sum += term;
    term *= x / 2 / (i + 1);
  }
  return sum;
}

TEST(Statistics, MedianIsTheUpperOne) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({1, 9}), 9);
  EXPECT_EQ(median({7, 1, 5}), 5);
}

// Of squared lengths of residuals with two coordinates, nearly half of which are outliers at most.
TEST(Statistics, RobustVarianceIsThatOfACoordinate) {
  Random random(1);
  std::vector<double> squares;
  for (int i = 0; i < 100'000; ++i)
    squares.push_back(9 * (std::pow(random.normal(), 2) + std::pow(random.normal(), 2)));
  EXPECT_NEAR(robust_variance(squares), 9, 0.02 * 9);
  for (int i = 0; i < 5'000; ++i) squares[static_cast<std::size_t>(i)] = 1e6;
  EXPECT_NEAR(robust_variance(squares), 9, 0.1 * 9);
}

TEST(Statistics, ChiSquareQuantilesAreExceededAsOftenAsANormalOne) {
  for (const int k : {2, 4, 10, 60, 400}) {
    for (const double z : {-1.0, 0.0, 1.0, 2.326, 3.09}) {
      const double tail = chi_square_tail(k, chi_square_quantile(k, z));
      EXPECT_NEAR(tail / normal_tail(z), 1, 0.16) << k << " " << z;  // the approximation is as good
    }
  }
}

// With a = 2 the ratio exceeds r with the probability (1 + 2 r / b)^(-b / 2).
TEST(Statistics, VarianceRatiosHaveANormalScore) {
  for (const double b : {10.0, 50.0, 400.0}) {
    for (const double ratio : {0.5, 1.0, 2.0, 4.0, 6.0}) {
      const double tail = std::pow(1 + 2 * ratio / b, -b / 2);
      EXPECT_NEAR(normal_tail(variance_ratio_score(ratio, 2, b)) / tail, 1, 0.15)
          << ratio << " " << b;
    }
  }
}

}  // namespace
}  // namespace tagcal
