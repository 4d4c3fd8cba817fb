#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/handeye/handeye_bundle.hpp"
#include "tagcal/estimate/policy/handeye_policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

RobotNoise times(const RobotNoise& noise, const Vector2d& log_factor) {
  return {noise.sigma_rad * std::exp(log_factor[0]), noise.sigma_m * std::exp(log_factor[1])};
}

constexpr double kLogStep = 0.1;  // numeric: of differences, of a logarithm

// Gradient and Hessian of the objective by the logarithms of the noise, by differences.
struct Curvature {
  double value = 0;
  Vector2d gradient;
  Matrix2d hessian;  // with positive eigenvalues
};
std::optional<Curvature> curvature(const HandeyeEquations& equations, const RobotNoise& noise) {
  double f[3][3];
  for (int i = -1; i <= 1; ++i)
    for (int k = -1; k <= 1; ++k) {
      const auto solved = equations.solve(times(noise, kLogStep * Vector2d(i, k)));
      if (!solved) return std::nullopt;
      f[i + 1][k + 1] = solved->objective;
    }
  constexpr double kSquare = kLogStep * kLogStep;
  Curvature c{f[1][1], {f[2][1] - f[0][1], f[1][2] - f[1][0]}, {}};
  c.gradient /= 2 * kLogStep;
  const double mixed = (f[2][2] - f[2][0] - f[0][2] + f[0][0]) / (4 * kSquare);
  c.hessian << (f[2][1] - 2 * f[1][1] + f[0][1]) / kSquare, mixed, mixed,
      (f[1][2] - 2 * f[1][1] + f[1][0]) / kSquare;
  const Eigen::SelfAdjointEigenSolver<Matrix2d> eigen(c.hessian);
  constexpr double kLeast = 0.1;  // numeric: a quarter of the prior's curvature
  c.hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(kLeast).asDiagonal() *
              eigen.eigenvectors().transpose();
  return c;
}

// Logarithm of the variance of the camera's place, in the geometric mean of its six parameters.
double log_scale(const HandeyeEquations& equations, const RobotNoise& noise) {
  const auto solved = equations.solve(noise);
  if (!solved) return 0;
  return std::log(solved->covariance.topLeftCorner<6, 6>().determinant()) / 6;
}

// The variance of the logarithm of a mean square of k degrees of freedom is 2 / k, nearly.
double freedoms(const HandeyeEquations& equations, const NoiseEstimate& found) {
  Vector2d by_noise;
  for (int i = 0; i < 2; ++i) {
    const Vector2d step = kLogStep * Vector2d::Unit(i);
    by_noise[i] = (log_scale(equations, times(found.noise, step)) -
                   log_scale(equations, times(found.noise, -step))) /
                  (2 * kLogStep);
  }
  const double variance = by_noise.dot(found.log_covariance * by_noise);
  constexpr double kMost = 1e6;  // numeric: without robot noise
  return std::min(kMost, 2 / std::max(variance, 1 / kMost));
}

// A share of the way from one state to another one.
HandeyeState between(const HandeyeState& from, const HandeyeState& to, double share) {
  const auto part = [&](const Pose& a, const Pose& b) { return retract(a, share * minus(b, a)); };
  HandeyeState state = from;
  state.places.mount_from_camera = part(from.places.mount_from_camera, to.places.mount_from_camera);
  state.places.holder_from_board = part(from.places.holder_from_board, to.places.holder_from_board);
  for (std::size_t k = 0; k < state.base_from_hand.size(); ++k)
    state.base_from_hand[k] = part(from.base_from_hand[k], to.base_from_hand[k]);
  state.log_board_scale += share * (to.log_board_scale - from.log_board_scale);
  state.time_offset_s += share * (to.time_offset_s - from.time_offset_s);
  return state;
}

struct Advance {
  HandeyeState state;
  HandeyeEquations equations;
};

// The state after a step, or after the part of it that a parabola through the costs prefers: the
// steps neglect second derivatives, and overshoot along axes that are nearly parallel. No value if
// none lowers the cost.
std::optional<Advance> advanced(const HandeyeProblem& problem, const HandeyeState& state,
                                const HandeyeEquations& equations, const RobotNoise& noise,
                                const HandeyeEquations::Solution& solved) {
  const HandeyeState end = equations.stepped(state, noise, solved.step);
  constexpr int kTries = 6;                         // a limit of work
  constexpr double kRounding = 1e-9;                // numeric: of the cost
  constexpr double kShortest = 0.1, kAgain = 0.75;  // numeric: of the step that was tried
  double share = 1;
  for (int i = 0; i < kTries; ++i) {
    HandeyeState next = i == 0 ? end : between(state, end, share);
    auto there = HandeyeEquations::at(problem, next);
    const auto cost = there ? there->solve(noise) : std::nullopt;
    double best = share / 2;  // numeric: a half
    if (cost) {
      const double slope = 2 * solved.decrease * share;
      const double rise = cost->cost - solved.cost;
      best = share * slope / (2 * std::max(rise + slope, kRounding * slope));
      const bool lower = rise <= kRounding * (1 + solved.cost);
      if (lower && (i > 0 || best > kAgain)) return Advance{std::move(next), *std::move(there)};
    }
    share = std::clamp(best, kShortest * share, kAgain * share);
  }
  return std::nullopt;
}

// The joint covariance, which includes that of the lens.
std::optional<MatrixXd> covariance_of(const HandeyeEquations& equations, const RobotNoise& noise,
                                      const UncertainCamera& camera) {
  const auto solved = equations.solve(noise);
  if (!solved) return std::nullopt;
  if (camera.covariance.size() == 0) return solved->covariance;
  const MatrixXd response = equations.response_to_lens(noise, solved->covariance);
  return MatrixXd(solved->covariance + response * camera.covariance * response.transpose());
}

}  // namespace

std::optional<NoiseEstimate> estimate_noise(const HandeyeEquations& equations,
                                            const RobotNoise& start) {
  constexpr int kSteps = 3;             // a limit of work: it continues in the next iteration
  constexpr double kLargestStep = 1.5;  // numeric: of a logarithm
  constexpr double kSmallStep = 0.02;   // numeric: 2 % of a standard deviation
  NoiseEstimate found{start, {}};
  auto at = curvature(equations, start);
  for (int i = 0; at && i < kSteps; ++i) {
    found.log_covariance = 2 * at->hessian.inverse();
    Vector2d step = -at->hessian.inverse() * at->gradient;
    step *= std::min(1.0, kLargestStep / std::max(step.norm(), kLargestStep));
    if (step.norm() < kSmallStep) break;
    auto next = curvature(equations, times(found.noise, step));
    if (next && next->value > at->value) {
      step /= 4;
      next = curvature(equations, times(found.noise, step));
      if (next && next->value > at->value) break;
    }
    found.noise = times(found.noise, step);
    at = next;
  }
  if (!at) return std::nullopt;
  return found;
}

std::optional<MatrixXd> covariance_at(const HandeyeProblem& problem, const HandeyeState& state,
                                      const RobotNoise& noise) {
  const auto equations = HandeyeEquations::at(problem, state);
  if (!equations) return std::nullopt;
  return covariance_of(*equations, noise, problem.camera);
}

std::optional<HandeyeMinimum> minimise_bundle(const HandeyeProblem& problem, HandeyeState start,
                                              const RobotNoise& noise) {
  HandeyeMinimum result{.state = std::move(start), .noise = {noise, {}}};
  auto equations = HandeyeEquations::at(problem, result.state);
  constexpr int kIterations = 20;      // a limit of work; beyond it is not_converged
  constexpr double kSmallStep = 1e-4;  // numeric: squared, in standard deviations, of a view
  // A translation that will be refused (check_determined) has no minimum: noise of the pictures
  // takes the place of errors of the robot, the cost falls without an end, and the other parameters
  // follow its curved valley. A bundle that has a minimum converges in the free steps; after them
  // the translation is held.
  constexpr int kFree = 5;     // numeric: steps
  constexpr double kHeld = 2;  // numeric: an answer at the bound is not held on its way
  const double held_m = kHeld * policy::kHandeyeRefused * problem.scale.distance_m;
  for (int i = 0; equations && i < kIterations && !result.converged; ++i) {
    if (i >= kFree) equations->hold_translation(held_m);
    const RobotNoise before = result.noise.noise;
    const auto found = estimate_noise(*equations, before);
    if (!found) return std::nullopt;
    result.noise = *found;
    const auto solved = equations->solve(found->noise);
    if (!solved) return std::nullopt;
    auto next = advanced(problem, result.state, *equations, found->noise, *solved);
    const bool small = solved->decrease < kSmallStep * static_cast<double>(problem.sights.size());
    result.objective = solved->objective;
    if (next) {
      result.state = std::move(next->state);
      equations = std::move(next->equations);
    }
    constexpr double kSame = 0.05;  // numeric: of a logarithm
    result.converged = (small || !next) &&
                       std::abs(std::log(found->noise.sigma_m / before.sigma_m)) < kSame &&
                       std::abs(std::log(found->noise.sigma_rad / before.sigma_rad)) < kSame;
    if (!next && !result.converged && i > 2) break;
  }
  if (!equations) return std::nullopt;
  const auto covariance = covariance_of(*equations, result.noise.noise, problem.camera);
  if (!covariance) return std::nullopt;
  result.covariance = *covariance;
  result.degrees_of_freedom = freedoms(*equations, result.noise);
  return result;
}

}  // namespace tagcal::internal
