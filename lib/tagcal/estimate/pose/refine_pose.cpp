#include "tagcal/estimate/pose/refine_pose.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
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

// True for a second hypothesis whose minimum is predicted above the limit, or that slides to the
// first minimum, because the decrease of its cost grows.
bool ruled_out(double cost, double decrease, double last_decrease, const RefineOptions& options) {
  if (std::isinf(options.ruled_out_cost)) return false;
  const bool above = cost - policy::kPredictedDecreases * decrease > options.ruled_out_cost;
  const bool slides = decrease > last_decrease && decrease > policy::kSlidingDecrease * cost;
  return above || slides;
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

}  // namespace

template <int N>
std::optional<PoseMinimum<N>> refine_pose(ViewSums& sums, const InitialPose<N>& start,
                                          const RefineOptions& options) {
  NormalEquations<N> buffers[2];
  const NormalEquations<N>* here = &start.equations;
  if (!start.has_equations) {
    if (!sums.at(start.state, buffers[0])) return std::nullopt;
    here = &buffers[0];
  }
  std::optional<PoseMinimum<N>> best(std::in_place);
  best->state = start.state;
  best->cost = here->cost;
  const double per_point = 1 / static_cast<double>(sums.num_points());
  StepLength<N> step_length;
  double damping = 0, last_decrease = std::numeric_limits<double>::infinity();
  for (int steps = 0; steps < options.max_iterations && damping < kLargestDamping;) {
    const auto predicted = step_at<N>(*here, damping);
    double length = 1;
    if (predicted && damping == 0) {
      if (ruled_out(best->cost, predicted->decrease, last_decrease, options)) return std::nullopt;
      last_decrease = predicted->decrease;
      length = step_length.next(here->gradient);
      best->converged =
          last_decrease < std::max(kLastDecrease, kLastShare * per_point * best->cost);
    }
    const ViewState next =
        predicted ? moved<N>(best->state, length * predicted->step) : best->state;
    NormalEquations<N>& there = buffers[here == &buffers[0]];
    if (best->converged) {
      best->state = next;
      best->cost = std::max(0.0, best->cost - last_decrease);
      break;
    }
    if (predicted && sums.at(next, there) && there.cost <= best->cost) {
      best->state = next;
      best->cost = there.cost;
      here = &there;
      ++steps;
      step_length.set_last(*predicted, damping == 0 ? length : 0);
      damping = damping > kLeastDamping ? damping / kDampingFactor : 0;
    } else {
      damping = std::max(kLeastDamping, kDampingFactor * damping);
    }
  }
  best->information = here->information;
  if (!best->converged)
    if (const auto left = step_at<N>(*here, 0))
      best->converged =
          damping >= kLargestDamping ||  // a minimum, up to rounding
          left->decrease < std::max(kLastDecrease, kEnoughShare * per_point * best->cost);
  return best;
}

template std::optional<PoseMinimum<6>> refine_pose<6>(ViewSums&, const InitialPose<6>&,
                                                      const RefineOptions&);
template std::optional<PoseMinimum<7>> refine_pose<7>(ViewSums&, const InitialPose<7>&,
                                                      const RefineOptions&);

}  // namespace tagcal::internal
