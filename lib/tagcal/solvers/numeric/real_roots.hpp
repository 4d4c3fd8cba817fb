#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

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

// A polynomial on [0, 1] by its Bernstein coefficients. The number of their sign changes is the
// number of roots in (0, 1), or exceeds it by an even number (Descartes' rule; Farouki, Computer
// Aided Geometric Design 2012, section 4).
template <std::size_t N>
struct Bernstein {
  std::array<double, N + 1> b;
  double low, width;  // the interval that [0, 1] stands for
  int depth;

  // Number of sign changes; 3 means three or more.
  int sign_changes() const {
    unsigned negative = 0;
    for (std::size_t i = 0; i <= N; ++i) negative |= static_cast<unsigned>(std::signbit(b[i])) << i;
    constexpr unsigned kPairs = (1U << N) - 1;
    const unsigned changes = (negative ^ (negative >> 1)) & kPairs;
    const unsigned but_one = changes & (changes - 1);
    return (changes != 0) + (but_one != 0) + ((but_one & (but_one - 1)) != 0);
  }

  // Halves the interval (de Casteljau): this becomes the first half, the second is returned.
  Bernstein split() {
    width /= 2;
    ++depth;
    Bernstein second{{}, low + width, width, depth};
    for (std::size_t level = 0; level <= N; ++level) {
      second.b[N - level] = b[N];
      for (std::size_t i = N; i > level; --i) b[i] = (b[i - 1] + b[i]) / 2;
    }
    return second;
  }
};

template <std::size_t N>
Bernstein<N> bernstein_on(const FixedPolynomial<N>& p, double low, double high) {
  std::array<double, N + 1> c = p.c;  // of p(low + x), then of p(low + (high - low) x)
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = N; j-- > i;) c[j] += low * c[j + 1];
  Bernstein<N> result{{}, low, high - low, 0};
  double power = 1, binomial = 1;
  for (std::size_t i = 0; i <= N; ++i) {
    result.b[i] = c[i] * power / binomial;
    power *= high - low;
    binomial *= static_cast<double>(N - i) / static_cast<double>(i + 1);
  }
  for (std::size_t level = 1; level <= N; ++level)  // b_i = sum over k of C(i, k) c_k
    for (std::size_t i = N; i >= level; --i) result.b[i] += result.b[i - 1];
  return result;
}

// Returns the root between a place where the polynomial is negative and one where it is not, by
// Newton's method from x inside the bracket; a simple root to about 1e-9 (1 + |root|).
template <std::size_t N>
double root_between(const FixedPolynomial<N>& p, double below, double above, double x) {
  if (!((x - below) * (x - above) < 0)) x = below + (above - below) / 2;
  for (int step = 0; step < 60; ++step) {
    double value = p.c[N], slope = 0;
    for (std::size_t k = N; k-- > 0;) {
      slope = slope * x + value;
      value = value * x + p.c[k];
    }
    (value < 0 ? below : above) = x;
    double next = x - value / slope;
    if (!((next - below) * (next - above) < 0)) next = below + (above - below) / 2;
    const double moved = std::abs(next - x);
    x = next;
    if (moved <= 1e-5 * (1 + std::abs(x))) break;
  }
  return x;
}

// Returns the root in an interval over which the coefficients change sign once.
template <std::size_t N>
double only_root(const FixedPolynomial<N>& p, const Bernstein<N>& interval) {
  const bool rises = std::signbit(interval.b[0]);
  std::size_t i = 1;
  while (i < N && std::signbit(interval.b[i]) == rises) ++i;
  // Starts where the control polygon crosses zero.
  const double share = interval.b[i - 1] / (interval.b[i - 1] - interval.b[i]);
  const double place = (static_cast<double>(i - 1) + share) / static_cast<double>(N);
  const double first = interval.low, last = interval.low + interval.width;
  return root_between(p, rises ? first : last, rises ? last : first,
                      first + interval.width * place);
}

template <std::size_t N>
FixedPolynomial<N - 1> derivative_of(const FixedPolynomial<N>& p) {
  FixedPolynomial<N - 1> d;
  for (std::size_t i = 1; i <= N; ++i) d.c[i - 1] = static_cast<double>(i) * p.c[i];
  return d;
}

// Adds the roots in an interval over which the coefficients change sign twice, or the extremum if
// there are none. Returns false if there may be more than one extremum.
template <std::size_t N, std::size_t M>
bool two_roots(const FixedPolynomial<N>& p, const Bernstein<N>& interval,
               Solutions<double, M>& roots) {
  Bernstein<N - 1> slope{{}, interval.low, interval.width, 0};
  for (std::size_t i = 0; i < N; ++i)
    slope.b[i] = (interval.b[i + 1] - interval.b[i]) / interval.width;
  if (slope.sign_changes() != 1) return false;
  const FixedPolynomial<N - 1> derivative = derivative_of(p);
  const double extremum = only_root(derivative, slope), value = p(extremum);
  const bool negative = std::signbit(value);
  if (negative == std::signbit(interval.b[0])) {
    roots.push_back(extremum);
    return true;
  }
  // Starts where the parabola at the extremum crosses zero.
  const double curvature = derivative_of(derivative)(extremum);
  const double reach = std::copysign(std::sqrt(std::abs(2 * value / curvature)), interval.width);
  for (const double side : {-1.0, 1.0}) {
    const double end = side < 0 ? interval.low : interval.low + interval.width;
    roots.push_back(root_between(p, negative ? extremum : end, negative ? end : extremum,
                                 extremum + side * reach));
  }
  return true;
}

// Returns the real roots between low < 0 and high > 0, and near roots: extrema that do not reach
// zero, and intervals whose roots (more than two) rounding does not separate. No root is missed: an
// interval is dropped only if its coefficients prove that it has none. Most roots are expected
// within a few units of zero.
template <std::size_t N>
Solutions<double, 2 * N> roots_and_near_roots(const FixedPolynomial<N>& p, double low,
                                              double high) {
  constexpr int kDepth = 40;
  constexpr double kNear = 8;
  std::array<Bernstein<N>, kDepth + 3> stack;  // not initialised: that would take longer
  stack[0] = bernstein_on(p, std::max(low, -kNear), std::min(high, kNear));
  std::size_t size = 1;
  if (high > kNear) stack[size++] = bernstein_on(p, kNear, high);
  if (low < -kNear) stack[size++] = bernstein_on(p, -kNear, low);
  Solutions<double, 2 * N> roots;
  while (size > 0 && roots.size() + 2 <= 2 * N) {
    Bernstein<N>& top = stack[size - 1];
    const int changes = top.sign_changes();
    if (changes == 1) roots.push_back(only_root(p, top));
    if (changes < 2 || (changes == 2 && two_roots(p, top, roots))) {
      --size;
    } else if (top.depth == kDepth || std::abs(top.width) < 1e-6 * std::abs(top.low)) {
      roots.push_back(top.low + top.width / 2);
      --size;
    } else {
      const Bernstein<N> second = top.split();
      stack[size] = top;
      stack[size - 1] = second;
      ++size;
    }
  }
  return roots;
}

}  // namespace tagcal::internal
