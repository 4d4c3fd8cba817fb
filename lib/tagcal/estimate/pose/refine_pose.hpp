#pragma once

#include <limits>
#include <optional>

#include "tagcal/estimate/pose/view_equations.hpp"

namespace tagcal::internal {

struct RefineOptions {
  int max_iterations = 50;
  // Refinement of a second hypothesis stops if its minimum is predicted above this cost.
  double ruled_out_cost = std::numeric_limits<double>::infinity();
  // The decrease of the cost by the step that led to the start.
  double last_decrease = std::numeric_limits<double>::infinity();
  double polish_variance = 0;  // of the noise, for `polished`; 0: precise enough to select a pose
};

// A start. Its cost is that of all points, with the normal equations there; or that of a subset, a
// lower bound of the cost of all, without equations.
template <int N>
struct InitialPose {
  ViewState state;
  double cost = 0;
  bool has_equations = false;
  NormalEquations<N> equations = {Eigen::Matrix<double, N, N>::Zero(),
                                  Eigen::Matrix<double, N, 1>::Zero()};
};

// N = 6: pose, 7: pose and log focal length.
template <int N>
struct PoseMinimum {
  ViewState state;
  double cost = 0;                          // sum of squared whitened residuals
  Eigen::Matrix<double, N, N> information;  // J'J there, upper triangle
  bool converged = false;
  double last_decrease = 0;  // of the cost, by the last step
};

// Returns the least-squares solution from a start, by Gauss-Newton steps (two or three evaluations
// from a good start), which are damped after one that raised the cost. No value if it is ruled out,
// or if the start is outside the lens' domain.
template <int N>
std::optional<PoseMinimum<N>> refine_pose(ViewSums& sums, const InitialPose<N>& start,
                                          const RefineOptions& options = {});

// Continues from a minimum to the precision of numbers. refine_pose ends a hundredth of a standard
// deviation before its minimum, with the information one step earlier: enough to select a pose, not
// to report it.
template <int N>
PoseMinimum<N> polished(ViewSums& sums, const PoseMinimum<N>& minimum, double sigma_px);

}  // namespace tagcal::internal
