#include "tagcal/solvers/numeric/minimise.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

struct Normal {
  Matrix2d information;
  Vector2d gradient;
  double cost = 0;

  std::optional<DampedStep<Vector2d>> step(double damping) const {
    Matrix2d damped = information;
    damped.diagonal() *= 1 + damping;
    const Eigen::FullPivLU<Matrix2d> lu(damped);
    if (!lu.isInvertible()) return std::nullopt;
    const Vector2d step = -lu.solve(gradient);
    return DampedStep<Vector2d>{step, -step.dot(gradient)};
  }
};

// Rosenbrock's valley with the minimum (1, 1), to the right of a border.
struct Valley {
  using State = Vector2d;
  double border = -2;
  mutable int evaluations = 0;

  std::optional<Normal> at(const Vector2d& x) const {
    ++evaluations;
    if (!(x.x() > border)) return std::nullopt;
    const Vector2d r(10 * (x.y() - x.x() * x.x()), 1 - x.x());
    Matrix2d j;
    j << -20 * x.x(), 10, -1, 0;
    return Normal{j.transpose() * j, j.transpose() * r, r.squaredNorm()};
  }
  static Vector2d stepped(const Vector2d& x, const Vector2d& step) { return x + step; }
};

TEST(Minimise, FollowsAValley) {
  const auto found = minimise(Valley{}, Vector2d(-1.2, 1));
  ASSERT_TRUE(found);
  EXPECT_LT((found->state - Vector2d(1, 1)).norm(), 1e-9);
  EXPECT_LT(found->at.cost, 1e-18);
}

TEST(Minimise, KeepsInsideTheDomain) {
  EXPECT_FALSE(minimise(Valley{0}, Vector2d(-1, 1)));
  const auto found = minimise(Valley{1.5}, Vector2d(3, 1));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->state.x(), 1.5, 1e-3);
  EXPECT_GT(found->state.x(), 1.5);
}

TEST(Minimise, StaysAtAMinimum) {
  const Valley valley;
  const auto found = minimise(valley, Vector2d(1, 1));
  EXPECT_EQ(found->state, Vector2d(1, 1));
  EXPECT_EQ(valley.evaluations, 1);
}

TEST(Minimise, EndsBeforeDecreasesThatDoNotMatter) {
  const auto found = minimise(Valley{}, Vector2d(1.01, 1.01 * 1.01), {.least_decrease = 1e-3});
  EXPECT_EQ(found->state, Vector2d(1.01, 1.01 * 1.01));
  const Valley valley;
  minimise(valley, Vector2d(-1.2, 1), {.max_steps = 3});
  EXPECT_LE(valley.evaluations, 4);
}

// The first coordinate changes nothing: an undamped step has no value.
struct Flat {
  using State = Vector2d;
  static std::optional<Normal> at(const Vector2d& x) {
    return Normal{Vector2d(0, 1).asDiagonal(), Vector2d(0, x.y()), x.y() * x.y()};
  }
  static Vector2d stepped(const Vector2d& x, const Vector2d& step) { return x + step; }
};

TEST(Minimise, EndsWhereNoStepHasAValue) {
  const auto found = minimise(Flat{}, Vector2d(1, 1), {.damping = 0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->state, Vector2d(1, 1));
}

}  // namespace
}  // namespace tagcal::internal
