#include "tagcal/camera/lenses/polynomial.hpp"

#include <algorithm>
#include <cmath>

namespace tagcal::internal {
namespace {

// The x between low and high at which the sign changes; f has opposite signs at the two.
double bisect(std::span<const double> c, double low, double high) {
  const bool low_is_negative = evaluate(c, low) < 0;
  while (true) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return high;
    ((evaluate(c, middle) < 0) == low_is_negative ? low : high) = middle;
  }
}

std::vector<double> sign_changes(std::span<const double> c, double limit) {
  while (!c.empty() && c.front() == 0) c = c.subspan(1);  // powers of x have no sign to change
  if (c.size() < 2) return {};
  std::vector<double> knots = sign_changes(derivative(c), limit);
  knots.push_back(limit);
  std::vector<double> roots;
  double low = 0;
  for (const double high : knots) {
    if ((evaluate(c, low) < 0) != (evaluate(c, high) < 0)) roots.push_back(bisect(c, low, high));
    low = high;
  }
  return roots;
}

}  // namespace

double evaluate(std::span<const double> coefficients, double x) {
  double value = 0;
  for (std::size_t i = coefficients.size(); i-- > 0;) value = value * x + coefficients[i];
  return value;
}

Polynomial derivative(std::span<const double> coefficients) {
  Polynomial d;
  for (std::size_t i = 1; i < coefficients.size(); ++i)
    d.push_back(static_cast<double>(i) * coefficients[i]);
  return d;
}

Polynomial multiply(std::span<const double> a, std::span<const double> b) {
  Polynomial product(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
  return product;
}

double smallest_positive_root(std::span<const double> coefficients, double limit) {
  const std::vector<double> roots = sign_changes(coefficients, limit);
  return roots.empty() ? std::numeric_limits<double>::infinity() : roots.front();
}

double solve_increasing(const std::function<std::pair<double, double>(double)>& f, double value,
                        double low, double high, double tolerance) {
  double x = std::clamp(value, low, high);
  for (int i = 0; i < 200; ++i) {
    const auto [fx, slope] = f(x);
    double next = x - (fx - value) / slope;
    if (std::abs(next - x) <= tolerance * std::abs(x)) return std::clamp(next, low, high);
    (fx < value ? low : high) = x;
    if (!(next > low && next < high)) next = low + (high - low) / 2;
    x = next;
  }
  return x;
}

}  // namespace tagcal::internal
