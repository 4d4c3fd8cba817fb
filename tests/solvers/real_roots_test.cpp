#include "tagcal/solvers/numeric/real_roots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tagcal/random.hpp"

namespace tagcal {
using namespace internal;
namespace {

TEST(RealRoots, AreAllFound) {
  Random random(10);
  for (int i = 0; i < 20000; ++i) {
    FixedPolynomial<6> p{{1}};
    std::vector<double> truth;
    // Three pairs: real, complex.
    FixedPolynomial<0> one{{random.uniform(0.5, 2)}};
    const auto pair = [&] {
      const double a = random.uniform(-12, 12), b = random.uniform(-12, 12);
      if (random.uniform() < 0.4) return FixedPolynomial<2>{{a * a + b * b, -2 * a, 1}};
      truth.insert(truth.end(), {a, b});
      return FixedPolynomial<2>{{a * b, -a - b, 1}};
    };
    const auto first = pair(), second = pair(), third = pair();
    p = one * first * second * third;
    const auto found = real_roots(p, -10, 11, true);
    for (const double root : truth) {
      const bool inside = root > -10 && root < 11;
      EXPECT_TRUE(!inside || std::any_of(found.begin(), found.end(),
                                         [root](double x) { return std::abs(x - root) < 1e-3; }))
          << i << " " << root;
    }
  }
}

}  // namespace
}  // namespace tagcal
