#pragma once

#include <algorithm>
#include <concepts>
#include <optional>
#include <utility>

namespace tagcal::internal {

// Minimises a sum of squares, or another cost with a positive Hessian, by damped steps (Levenberg
// 1944, Marquardt 1963).
//
// A problem offers
//   State                                          what is varied
//   std::optional<Equations> at(const State&)      no value outside its domain
//   State stepped(const State&, const Step&)       the state after a step
// and its equations
//   double cost
//   std::optional<DampedStep<Step>> step(double damping)
//                                                  the step that minimises the model of the cost
//                                                  with this damping of its diagonal (a share, or
//                                                  as the problem scales it); no value if it has no
//                                                  minimum
template <typename Step>
struct DampedStep {
  Step step;
  double decrease = 0;  // of the cost, as its model predicts
};

template <typename P>
concept LeastSquaresProblem = requires(const P& problem, const typename P::State& state) {
  { problem.at(state)->cost } -> std::convertible_to<double>;
  { problem.stepped(state, problem.at(state)->step(1.0)->step) } -> std::same_as<typename P::State>;
};

// A step is taken unless it leaves the domain or raises the cost; its damping is then a tenth, else
// ten times of the last one. Ends before a step that predicts no decrease which matters. (A
// strongly damped step predicts little everywhere.)
struct MinimiseRules {
  double damping = 1e-3;      // of the first step
  double flat = 1e-13;        // share of the cost that does not matter
  double least_decrease = 0;  // decrease that does not matter
  double rounding = 0;        // of the cost: a step may raise it by that
  int max_steps = 200;        // tried ones
};

template <LeastSquaresProblem Problem, typename Equations>
struct Minimum {
  typename Problem::State state;
  Equations at;
};

// No value if the start is outside the domain.
template <LeastSquaresProblem Problem>
auto minimise(const Problem& problem, typename Problem::State start,
              const MinimiseRules& rules = {}) {
  constexpr double kLeastDamping = 1e-12, kLeastRaised = 1e-6, kMostDamping = 1e10;
  constexpr double kStrong = 1, kLess = 0.1, kMore = 10;  // numeric: as usual
  using Equations = std::decay_t<decltype(*problem.at(start))>;
  using Result = Minimum<Problem, Equations>;
  auto at_start = problem.at(start);
  if (!at_start) return std::optional<Result>();
  std::optional<Result> best(Result{std::move(start), *std::move(at_start)});
  double damping = rules.damping;
  for (int i = 0; i < rules.max_steps && damping < kMostDamping; ++i) {
    const double cost = best->at.cost;
    const auto step = best->at.step(damping);
    if (step && damping < kStrong && step->decrease <= rules.least_decrease + rules.flat * cost)
      break;
    bool is_taken = false;
    if (step) {
      auto state = problem.stepped(best->state, step->step);
      if (auto there = problem.at(state); there && there->cost <= cost + rules.rounding) {
        *best = {std::move(state), *std::move(there)};
        is_taken = true;
      }
    }
    damping = is_taken ? kLess * damping : std::max(kLeastRaised, kMore * damping);
    if (damping < kLeastDamping) damping = 0;
  }
  return best;
}

}  // namespace tagcal::internal
