#pragma once

#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace tagcal::internal {

// A polynomial by its coefficients, the constant first.
using Polynomial = std::vector<double>;

double evaluate(std::span<const double> coefficients, double x);
Polynomial derivative(std::span<const double> coefficients);
Polynomial multiply(std::span<const double> a, std::span<const double> b);

// The smallest x in (0, limit] at which the polynomial changes its sign, to the last bits; infinity
// where it does not. Found between the extrema, which are found the same way: no root is passed
// over.
double smallest_positive_root(std::span<const double> coefficients, double limit);

// x in [low, high] with f(x) = value, for an f that increases there, by Newton's method kept inside
// the bracket until a step is no longer than the tolerance, relative to x. f(low) <= value <=
// f(high) must hold. `f` returns {f(x), f'(x)}.
double solve_increasing(const std::function<std::pair<double, double>(double)>& f, double value,
                        double low, double high, double tolerance = 1e-16);

}  // namespace tagcal::internal
