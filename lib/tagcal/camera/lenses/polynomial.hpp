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
// if there is none. Searches between the extrema, which are found the same way, so that no root is
// missed.
double smallest_positive_root(std::span<const double> coefficients, double limit);

// Solves f(x) = value in [low, high] for an increasing f, by Newton's method inside a bracket
// from x = value, until a step is at most the tolerance relative to x. Precondition: f(low) <=
// value <= f(high). `f` returns {f(x), f'(x)}.
double solve_increasing(const std::function<std::pair<double, double>(double)>& f, double value,
                        double low, double high, double tolerance = 4e-16);

}  // namespace tagcal::internal
