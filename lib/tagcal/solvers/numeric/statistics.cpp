#include "tagcal/solvers/numeric/statistics.hpp"

#include <math.h>  // lgamma_r, of POSIX

#include <algorithm>
#include <cmath>

namespace tagcal::internal {

double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double robust_variance(std::span<const double> squares) {
  return median({squares.begin(), squares.end()}) / (2 * std::log(2.0));
}

double chi_square_quantile(double k, double normal_quantile) {
  const double root = 1 - 2 / (9 * k) + normal_quantile * std::sqrt(2 / (9 * k));
  return k * root * root * root;
}

double variance_ratio_score(double ratio, double a, double b) {
  const double root = std::cbrt(ratio), u = 2 / (9 * a), v = 2 / (9 * b);
  return ((1 - v) * root - (1 - u)) / std::sqrt(u + v * root * root);
}

double noncentrality(double k, double normal_quantile, double power_quantile) {
  const double value = chi_square_quantile(k, normal_quantile);
  // The value that is exceeded, in standard deviations of the cube root below its mean.
  const auto score = [&](double lambda) {
    const double variance = 2 * (1 + lambda / (k + lambda)) / (9 * (k + lambda));
    return (1 - variance - std::cbrt(value / (k + lambda))) / std::sqrt(variance);
  };
  double low = 0, high = k + value;
  while (score(high) < power_quantile) high *= 2;
  while (high - low > 1e-9 * high) {  // numeric: precision of the bisection
    const double middle = (low + high) / 2;
    (score(middle) < power_quantile ? low : high) = middle;
  }
  return high;
}

}  // namespace tagcal::internal
