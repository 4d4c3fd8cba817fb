#include "tagcal/estimate/pose/refine_pose.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

template <int N>
using Step = Eigen::Matrix<double, N, 1>;

// A step is the last one if its predicted decrease of the cost is below this share of a point's
// part of the cost (or, without noise, below this many squared whitened pixels). Its length is then
// about a hundredth of a standard deviation, and the remaining error is far smaller.
constexpr double kLastShare = 2e-4;      // numeric: convergence
constexpr double kLastDecrease = 1e-14;  // numeric: convergence
// The same share after the last iteration, in a flat valley.
constexpr double kEnoughShare = 1e-3;  // numeric: convergence

// A minimum that is reported, in sigma^2: the step after the last one, as the steps converge, is
// shorter than the root of the first in standard deviations; the last one, which the information
// does not take part in, than that of the second.
constexpr double kPolishedDecrease = 1e-17;        // numeric: convergence
constexpr double kNearlyPolishedDecrease = 1e-11;  // numeric: convergence
// Share of the cost below which its change is rounding: pixels are rounded by 1e-13 px and more.
constexpr double kRounding = 1e-11;  // numeric: rounding

// Damping: the least, its factor, and the one at which no step lowers the cost.
constexpr double kLeastDamping = 1e-6;   // numeric: tried values
constexpr double kDampingFactor = 10;    // numeric: tried values
constexpr double kLargestDamping = 1e6;  // numeric: tried values

template <int N>
struct PredictedStep {
  Step<N> step;
  double decrease;  // of the cost
};

// Scales the Gauss-Newton steps. With J'J as the Hessian they are too short (or too long) by a
// constant factor where residuals and curvature are large, as between the two poses of a far plane.
// The change of the gradient along the last step gives the factor (secant rule).
template <int N>
class StepLength {
 public:
  // Length of the next step; `gradient` is the one after the last step.
  double next(const Step<N>& gradient) const {
    constexpr double kLongest = 4;
    if (length_ == 0) return 1;
    const double curvature = (1 + gradient.dot(last_.step) / last_.decrease) / length_;
    return curvature > 1 / kLongest ? 1 / curvature : kLongest;
  }
  void set_last(const PredictedStep<N>& last, double length) {
    last_ = last;
    length_ = length;
  }

 private:
  PredictedStep<N> last_{Step<N>::Zero(), 0};
  double length_ = 0;
};

// True if a step with such a decrease of the cost may be the last one.
bool is_last(double decrease, double last_decrease, double cost_per_point,
             const RefineOptions& options) {
  if (options.polish_variance == 0)
    return decrease < std::max(kLastDecrease, kLastShare * cost_per_point);
  const double next_decrease = decrease * std::min(1.0, decrease / last_decrease);
  return next_decrease < kPolishedDecrease * options.polish_variance &&
         decrease < kNearlyPolishedDecrease * options.polish_variance;
}

// Gauss-Newton step with the diagonal of J'J enlarged by a share (Levenberg 1944, Marquardt 1963),
// which does not depend on the units. No value if the matrix is singular.
template <int N>
std::optional<PredictedStep<N>> step_at(const NormalEquations<N>& at, double damping) {
  Eigen::Matrix<double, N, N> damped = at.information;
  damped.diagonal() *= 1 + damping;
  SmallCholesky<N> cholesky;
  if (!cholesky.compute(damped)) return std::nullopt;
  const Step<N> step = -cholesky.solve(at.gradient);
  return PredictedStep<N>{step, -step.dot(at.gradient)};
}

// True for a step to a lower cost; where rounding hides that, to a smaller Gauss-Newton step.
template <int N>
bool is_progress(const NormalEquations<N>& here, const NormalEquations<N>& there) {
  if (!(std::abs(there.cost - here.cost) < kRounding * here.cost)) return there.cost <= here.cost;
  const auto last = step_at<N>(here, 0), next = step_at<N>(there, 0);
  return last && next && next->decrease < last->decrease;
}

// The equations of a start, in the buffer if it has none. Null outside the lens' domain.
template <int N>
const NormalEquations<N>* equations_of(const InitialPose<N>& start, ViewSums& sums,
                                       NormalEquations<N>& buffer) {
  if (start.has_equations) return &start.equations;
  return sums.at(start.state, buffer) ? &buffer : nullptr;
}

// Sets the information, and whether no step lowers the cost: at a minimum, up to rounding, or by
// little.
template <int N>
void end_at(const NormalEquations<N>& here, double damping, double cost_per_point,
            PoseMinimum<N>& best) {
  best.information = here.information;
  if (best.converged) return;
  const auto left = step_at<N>(here, 0);
  best.converged =
      left && (damping >= kLargestDamping ||
               left->decrease < std::max(kLastDecrease, kEnoughShare * cost_per_point));
}

double raised(double damping) { return std::max(kLeastDamping, kDampingFactor * damping); }
double lowered(double damping) { return damping > kLeastDamping ? damping / kDampingFactor : 0; }

}  // namespace

template <int N>
std::optional<PoseMinimum<N>> refine_pose(ViewSums& sums, const InitialPose<N>& start,
                                          const RefineOptions& options) {
  NormalEquations<N> buffers[2];
  const NormalEquations<N>* here = equations_of(start, sums, buffers[0]);
  if (!here) return std::nullopt;
  std::optional best(PoseMinimum<N>{start.state, here->cost, {}, false, options.last_decrease});
  const double per_point = 1 / static_cast<double>(sums.num_points());
  StepLength<N> step_length;
  double damping = 0;
  for (int steps = 0; steps < options.max_iterations && damping < kLargestDamping;) {
    const auto predicted = step_at<N>(*here, damping);
    double length = 1;
    if (predicted && damping == 0) {
      const double last = std::exchange(best->last_decrease, predicted->decrease);
      // A step lowers the cost by the predicted decrease, or by little more.
      if (best->cost - 2 * predicted->decrease > options.ruled_out_cost) return std::nullopt;
      best->converged = is_last(predicted->decrease, last, best->cost * per_point, options);
      length = step_length.next(here->gradient);
    }
    NormalEquations<N>& there = buffers[here == &buffers[0]];
    const ViewState next =
        predicted ? moved<N>(best->state, length * predicted->step) : best->state;
    if (best->converged) {
      best->state = next;
      best->cost = std::max(0.0, best->cost - best->last_decrease);
      break;
    }
    if (predicted && sums.at(next, there) && is_progress<N>(*here, there)) {
      best->state = next;
      best->cost = there.cost;
      here = &there;
      ++steps;
      step_length.set_last(*predicted, damping == 0 ? length : 0);
      damping = lowered(damping);
    } else {
      damping = raised(damping);
    }
  }
  end_at(*here, damping, best->cost * per_point, *best);
  return best;
}

template <int N>
PoseMinimum<N> polished(ViewSums& sums, const PoseMinimum<N>& minimum, double sigma_px) {
  InitialPose<N> start{minimum.state};
  if (!minimum.converged || !sums.at(start.state, start.equations)) return minimum;
  start.has_equations = true;
  RefineOptions options;
  options.max_iterations = 200;
  options.last_decrease = minimum.last_decrease;
  options.polish_variance = sigma_px * sigma_px;
  return refine_pose<N>(sums, start, options).value_or(minimum);
}

template PoseMinimum<6> polished(ViewSums&, const PoseMinimum<6>&, double);
template PoseMinimum<7> polished(ViewSums&, const PoseMinimum<7>&, double);
template std::optional<PoseMinimum<6>> refine_pose<6>(ViewSums&, const InitialPose<6>&,
                                                      const RefineOptions&);
template std::optional<PoseMinimum<7>> refine_pose<7>(ViewSums&, const InitialPose<7>&,
                                                      const RefineOptions&);

}  // namespace tagcal::internal
