#include "tagcal/estimate/pose/refine_pose.hpp"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <int N>
using Step = Eigen::Matrix<double, N, 1>;

// A step is the last one if its predicted decrease of the cost is below this share of a point's
// part of the cost (or, without noise, below this many squared whitened pixels). Its length is then
// about a hundredth of a standard deviation, and the remaining error is far smaller.
constexpr double kLastShare = 2e-4;      // numeric: convergence
constexpr double kLastDecrease = 1e-14;  // numeric: convergence

constexpr int kMaxGaussNewton = 12;

// The rotation of the quaternion (1, omega / 2): equal to the exponential to second order.
[[gnu::always_inline]] inline Matrix3d small_rotation(const Vector3d& omega) {
  const double x = omega.x() / 2, y = omega.y() / 2, z = omega.z() / 2;
  const double s = 2 / (1 + x * x + y * y + z * z);
  Matrix3d r;
  r << 1 - s * (y * y + z * z), s * (x * y - z), s * (x * z + y),  //
      s * (x * y + z), 1 - s * (x * x + z * z), s * (y * z - x),   //
      s * (x * z - y), s * (y * z + x), 1 - s * (x * x + y * y);
  return r;
}

template <int N>
ViewState moved(const ViewState& state, const Step<N>& step) {
  ViewState next;
  next.rotation.noalias() = small_rotation(step.template head<3>()) * state.rotation;
  next.translation = state.translation + step.template segment<3>(3);
  if constexpr (N == 7) next.focal_px = state.focal_px * std::exp(step[6]);
  return next;
}

enum class Outcome { converged, ruled_out, failed };

// Scales the Gauss-Newton steps. With J'J as the Hessian they are too short (or too long) by a
// constant factor where residuals and curvature are large, as between the two poses of a far plane.
// The change of the gradient along the last step gives the factor (secant rule).
template <int N>
class StepLength {
 public:
  // Length of the next step; `gradient` is the one after the last step.
  double next(const Step<N>& gradient) const {
    if (last_decrease_ == 0) return 1;
    const double curvature = (1 + gradient.dot(last_) / last_decrease_) / length_;
    return curvature > 1 / kLongest ? 1 / curvature : kLongest;
  }
  void set_last(const Step<N>& gauss_newton_step, double decrease, double length) {
    last_ = gauss_newton_step;
    last_decrease_ = decrease;
    length_ = length;
  }

 private:
  static constexpr double kLongest = 4;

  Step<N> last_ = Step<N>::Zero();
  double last_decrease_ = 0;
  double length_ = 1;
};

// True for a second hypothesis whose minimum is predicted above the limit, or that slides to the
// first minimum, because the decrease of its cost grows.
bool ruled_out(double cost, double decrease, double last_decrease, const RefineOptions& options) {
  if (std::isinf(options.ruled_out_cost)) return false;
  const bool above = cost - policy::kPredictedDecreases * decrease > options.ruled_out_cost;
  const bool slides = decrease > last_decrease && decrease > policy::kSlidingDecrease * cost;
  return above || slides;
}

// Line search: moves the best state along the step by the length, or by a part that lowers the
// cost. `length` and `equations` become those of the new state.
template <int N>
bool search(ViewSums& sums, const Step<N>& step, PoseMinimum<N>& best, double& length,
            NormalEquations<N>& equations) {
  constexpr double kShortest = 1.0 / 16;
  for (; length > kShortest; length = length > 1 ? 1 : length / 4) {
    const ViewState next = moved<N>(best.state, length * step);
    if (!sums.at(next, equations) || equations.cost > best.cost) continue;
    best.state = next;
    return true;
  }
  return false;
}

// Takes steps while they lower the cost. If the outcome is `failed`, the solution is the best point
// so far, without its information.
template <int N>
Outcome gauss_newton(ViewSums& sums, const RefineOptions& options, NormalEquations<N>& equations,
                     PoseMinimum<N>& best) {
  SmallCholesky<N> cholesky;
  StepLength<N> step_length;
  double last_decrease = std::numeric_limits<double>::infinity();
  const int count = std::min(options.max_iterations, kMaxGaussNewton);
  const double last_share = kLastShare / static_cast<double>(sums.num_points());
  for (int i = 0; i < count; ++i) {
    best.cost = equations.cost;
    if (!cholesky.compute(equations.information)) return Outcome::failed;
    const Step<N> forward = cholesky.forward(equations.gradient);
    const Step<N> scaled = forward.cwiseProduct(cholesky.inverse_pivots());
    const Step<N> step = -cholesky.backward(scaled);
    const double decrease = forward.dot(scaled);
    if (ruled_out(equations.cost, decrease, last_decrease, options)) return Outcome::ruled_out;
    last_decrease = decrease;
    double length = step_length.next(equations.gradient);
    if (decrease < std::max(kLastDecrease, last_share * equations.cost)) {
      best.state = moved<N>(best.state, length * step);
      best.cost = std::max(0.0, equations.cost - decrease);
      best.information = equations.information;
      return Outcome::converged;
    }
    if (!search(sums, step, best, length, equations)) return Outcome::failed;
    step_length.set_last(step, decrease, length);
  }
  best.cost = equations.cost;
  return Outcome::failed;
}

// Problem for ceres::TinySolver. Its rows are the Cholesky factor of the normal equations: N + 1
// rows with the same cost, gradient and J'J as all rows of all points.
template <int N>
class TinyProblem {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = N + 1, NUM_PARAMETERS = N };

  TinyProblem(ViewSums& sums, const ViewState& reference)
      : sums_(sums), reference_(state_of(pose_of(reference), reference.focal_px)) {
    const double distance = reference.translation.norm();
    length_ = distance > 0 ? distance : 1;
  }

  ViewState state(const Step<N>& x) const {
    ViewState state;
    state.rotation =
        exp_rotation(Vector3d(x.template head<3>())).toRotationMatrix() * reference_.rotation;
    state.translation = reference_.translation + length_ * x.template segment<3>(3);
    if constexpr (N == 7) state.focal_px = reference_.focal_px * std::exp(x[6]);
    return state;
  }

  // TinySolver ignores failures, so a step out of the domain gets a cost that is never accepted.
  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const Step<N> x = Eigen::Map<const Step<N>>(parameters);
    Eigen::Map<Step<N + 1>> rows(residuals);
    NormalEquations<N> equations;
    SmallCholesky<N> cholesky;
    if (!x.allFinite() || !sums_.at(state(x), equations)) {
      rows.setConstant(1e100);
      return false;
    }
    // A little damping keeps the factor near a singular point.
    for (double damping = 0; !cholesky.compute(equations.information);
         damping = std::max(1e-12, 10 * damping)) {  // numeric: tried values
      if (!(damping < 1)) return false;
      equations.information.diagonal() *= 1 + damping;
      equations.information.diagonal().array() += std::numeric_limits<double>::min();
    }
    const Step<N> half =
        cholesky.forward(equations.gradient).cwiseProduct(cholesky.inverse_pivots().cwiseSqrt());
    rows << half, std::sqrt(std::max(0.0, equations.cost - half.squaredNorm()));
    if (!jacobian) return true;
    Eigen::Map<Eigen::Matrix<double, N + 1, N>> j(jacobian);
    j.setZero();
    j.template topRows<N>() = cholesky.factor();
    j.template leftCols<3>() =
        (j.template leftCols<3>() * left_jacobian(Vector3d(x.template head<3>()))).eval();
    j.template middleCols<3>(3) *= length_;
    return true;
  }

 private:
  ViewSums& sums_;
  ViewState reference_;
  double length_ = 1;  // of translation steps, so that no unit of length is special
};

template <int N>
bool levenberg_marquardt(ViewSums& sums, int max_iterations, PoseMinimum<N>& best) {
  const TinyProblem<N> problem(sums, best.state);
  using Solver = ceres::TinySolver<TinyProblem<N>>;
  Solver solver;
  solver.options.max_num_iterations = max_iterations;
  solver.options.gradient_tolerance = 1e-12;  // numeric: convergence
  solver.options.function_tolerance = 1e-16;  // numeric: convergence, squared whitened pixels
  solver.options.cost_threshold = 1e-24;      // numeric: convergence
  Step<N> x = Step<N>::Zero();
  const auto& summary = solver.Solve(problem, &x);
  const ViewState state = problem.state(x);
  NormalEquations<N> equations;
  if (x.allFinite() && sums.at(state, equations) && equations.cost <= best.cost)
    best = {state, equations.cost, equations.information, false};
  else if (!sums.at(best.state, equations))
    return false;
  best.information = equations.information;
  // In a flat valley the steps may not end: the predicted decrease then decides.
  SmallCholesky<N> cholesky;
  if (!cholesky.compute(equations.information)) return false;
  const double decrease = equations.gradient.dot(cholesky.solve(equations.gradient));
  return summary.status != Solver::HIT_MAX_ITERATIONS ||
         decrease <
             policy::kConvergedDecrease * equations.cost / static_cast<double>(sums.num_points());
}

}  // namespace

template <int N>
std::optional<PoseMinimum<N>> refine_pose(ViewSums& sums, const InitialPose<N>& start,
                                          const RefineOptions& options) {
  std::optional<PoseMinimum<N>> best(std::in_place);
  best->state = start.state;
  NormalEquations<N> equations;
  if (start.has_equations)
    equations = start.equations;
  else if (!sums.at(start.state, equations))
    return std::nullopt;
  const Outcome outcome = gauss_newton(sums, options, equations, *best);
  if (outcome == Outcome::ruled_out) return std::nullopt;
  best->converged =
      outcome == Outcome::converged || levenberg_marquardt(sums, options.max_iterations, *best);
  return best;
}

template std::optional<PoseMinimum<6>> refine_pose<6>(ViewSums&, const InitialPose<6>&,
                                                      const RefineOptions&);
template std::optional<PoseMinimum<7>> refine_pose<7>(ViewSums&, const InitialPose<7>&,
                                                      const RefineOptions&);

}  // namespace tagcal::internal
