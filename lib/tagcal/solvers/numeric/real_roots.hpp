#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tagcal/solvers/solutions.hpp"

// Polynomials of a degree known at compile time, without heap.

namespace tagcal::internal {

// c[0] + c[1] x + ... + c[N] x^N
template <std::size_t N>
struct FixedPolynomial {
  std::array<double, N + 1> c{};

  double operator()(double x) const {
    double value = c[N];
    for (std::size_t i = N; i-- > 0;) value = value * x + c[i];
    return value;
  }

  double largest() const {  // of the coefficients, without their signs
    double result = 0;
    for (const double x : c) result = std::max(result, std::abs(x));
    return result;
  }
};

template <std::size_t N, std::size_t M>
FixedPolynomial<N + M> operator*(const FixedPolynomial<N>& a, const FixedPolynomial<M>& b) {
  FixedPolynomial<N + M> product;
  for (std::size_t i = 0; i <= N; ++i)
    for (std::size_t j = 0; j <= M; ++j) product.c[i + j] += a.c[i] * b.c[j];
  return product;
}

// The sum has the higher of the two degrees.
template <std::size_t N, std::size_t M>
auto operator+(const FixedPolynomial<N>& a, const FixedPolynomial<M>& b) {
  if constexpr (N < M) {
    return b + a;
  } else {
    FixedPolynomial<N> sum = a;
    for (std::size_t i = 0; i <= M; ++i) sum.c[i] += b.c[i];
    return sum;
  }
}

template <std::size_t N>
FixedPolynomial<N> operator-(const FixedPolynomial<N>& a) {
  FixedPolynomial<N> negative;
  for (std::size_t i = 0; i <= N; ++i) negative.c[i] = -a.c[i];
  return negative;
}

template <std::size_t N, std::size_t M>
auto operator-(const FixedPolynomial<N>& a, const FixedPolynomial<M>& b) {
  return a + (-b);
}

template <std::size_t N>
FixedPolynomial<N - 1> derivative_of(const FixedPolynomial<N>& p) {
  FixedPolynomial<N - 1> d;
  for (std::size_t i = 1; i <= N; ++i) d.c[i - 1] = static_cast<double>(i) * p.c[i];
  return d;
}

// Returns the root between a place where the polynomial is negative and one where it is not, by
// Newton's method, and by bisection where that leaves the bracket or does not halve its step.
template <std::size_t N>
double root_between(const FixedPolynomial<N>& p, double below, double above) {
  const FixedPolynomial<N - 1> slope = derivative_of(p);
  double x = below + (above - below) / 2, last = std::abs(above - below);
  for (int step = 0; step < 200 && last > 1e-9 * (1 + std::abs(x)); ++step) {
    const double value = p(x), newton = x - value / slope(x);
    (value < 0 ? below : above) = x;
    const bool is_good = (newton - below) * (newton - above) <= 0 && std::abs(newton - x) < last / 2;
    const double next = is_good ? newton : below + (above - below) / 2;
    last = std::abs(next - x);
    x = next;
  }
  return x;
}

// Returns the places between low and high, ascending, where |p| has a minimum: the real roots and,
// if `near_roots`, the extrema that do not reach zero. Between two extrema, the roots of the
// derivative, there is at most one root.
template <std::size_t N>
Solutions<double, N> real_roots(const FixedPolynomial<N>& p, double low, double high,
                                bool near_roots = false) {
  Solutions<double, N> roots;
  if constexpr (N == 1) {
    const double root = -p.c[0] / p.c[1];
    if (root > low && root < high) roots.push_back(root);
  } else {
    double last = low, at_last = p(low);
    bool falls = false;  // |p|, before the last extremum
    const auto add = [&](double x) {
      const double value = p(x);
      const bool crosses = std::signbit(value) != std::signbit(at_last);
      const bool rises = !crosses && std::abs(value) > std::abs(at_last);
      if (near_roots && falls && rises) roots.push_back(last);
      if (crosses)
        roots.push_back(std::signbit(value) ? root_between(p, x, last) : root_between(p, last, x));
      falls = !crosses && !rises;
      last = x;
      at_last = value;
    };
    for (const double extremum : real_roots(derivative_of(p), low, high)) add(extremum);
    add(high);
  }
  return roots;
}

}  // namespace tagcal::internal
