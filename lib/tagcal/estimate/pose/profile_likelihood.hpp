#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {

// The covariance of a least-squares solution, widened by the profile likelihood.
//
// The linear covariance C predicts that the cost rises by e' C^-1 e sigma^2 at a step e. The cost
// rises by less where the likelihood is flat (the tilt of a plane that faces the camera), where it
// has a second minimum (the plane tilted the other way), and where parameters depend on one another
// by a curve (a turn by a changes the scale by a^2 / 2; focal length and distance). The profile
// therefore steps along a linear function of the parameters, minimises the cost over the others
// (Bates & Watts, Nonlinear Regression Analysis, 1988; Venzon & Moolgavkar, Applied Statistics
// 1988), and goes on while the cost hardly rises. A step of t standard deviations is e = t u + d,
// with the tangent u of the linear covariance and an offset d across it, and raises the cost by
// p sigma^2. C is widened along d, so that d has a Mahalanobis distance of at most 1, or the square
// root of 1 and of what the cost rises beyond t^2; then along e, so that e has at most sqrt(p):
// adding (1 / most - 1 / m) v v' to C reduces a squared distance v' C^-1 v = m to `most`.
//
// A Likelihood has the types State, Step, Matrix, Equations (information J'J, gradient J'r, cost)
// and Solver (compute(information), solve(Step)), and
//   int rounds()                                Gauss-Newton steps of a minimisation
//   bool at(State&, Equations&)                 false outside the domain; may optimise the part of
//                                               the state that is not in the step
//   State stepped(const State&, const Step&)    the state after a step
template <typename Likelihood>
class ProfileLikelihood {
 public:
  using State = typename Likelihood::State;
  using Step = typename Likelihood::Step;
  using Matrix = typename Likelihood::Matrix;

  // The solution, and C^-1 and C there for noise of `sigma`. References must outlive it.
  ProfileLikelihood(Likelihood& likelihood, const State& best, double cost, double sigma,
                    const Matrix& information, const Matrix& covariance)
      : likelihood_(likelihood),
        best_(best),
        cost_(cost),
        variance_(sigma * sigma),
        information_(information),
        covariance_(covariance) {}

  // A linear function of the step with a standard deviation of 1, and the most likely step with a
  // value of 1, by the linear covariance.
  struct Direction {
    Step function, tangent;
  };

  // Widens the covariance by the profile along a direction: at `level` standard deviations
  // (negative to the other side), then at twice as many each time while the cost rises by less than
  // kProfileEnd, up to `longest`. Stops where that leaves the domain.
  void widen(const Direction& direction, double level, double longest) {
    Step step = Step::Zero(direction.tangent.size());
    double reached = 0, rise = 0;
    while (std::abs(reached) < longest && rise < policy::kProfileEnd) {
      const double next = std::clamp(reached == 0 ? level : 2 * reached, -longest, longest);
      step += (next - reached) * direction.tangent;
      reached = next;
      rise = (minimise_across(direction.function, step) - cost_) / variance_;
      const double tangent_rise = reached * reached;
      widen(step - reached * direction.tangent, 1 + std::max(0.0, rise - tangent_rise));
      widen(step, std::max(rise, 1.0));
    }
  }

  const Matrix& covariance() const { return covariance_; }

 private:
  // Gives a step the squared Mahalanobis distance `most` if its own is larger.
  void widen(const Step& step, double most) {
    const Step row = information_ * step;
    const double distance_square = step.dot(row);
    if (!(distance_square > most)) return;
    covariance_ += (1 / most - 1 / distance_square) * step * step.transpose();
    information_ -= (1 - most / distance_square) / distance_square * row * row.transpose();
  }

  // Minimises the cost over the steps with the same value of the linear function. Returns the
  // predicted cost, infinite outside the domain.
  double minimise_across(const Step& function, Step& step) {
    State state = likelihood_.stepped(best_, step);
    typename Likelihood::Equations here;
    typename Likelihood::Solver solver;
    for (int round = 1;; ++round) {
      if (!likelihood_.at(state, here) || !solver.compute(here.information))
        return std::numeric_limits<double>::infinity();
      const Step p = solver.solve(here.gradient), q = solver.solve(function);
      const Step across = q * (function.dot(p) / function.dot(q)) - p;
      step += across;
      if (round == likelihood_.rounds()) return here.cost + here.gradient.dot(across);
      state = likelihood_.stepped(state, across);
    }
  }

  Likelihood& likelihood_;
  const State& best_;
  double cost_, variance_;
  Matrix information_, covariance_;
};

}  // namespace tagcal::internal
