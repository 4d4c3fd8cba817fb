#pragma once

#include <limits>
#include <optional>

#include "tagcal/estimate/pose/view_equations.hpp"

namespace tagcal::internal {

struct ViewSolverOptions {
  int max_iterations = 50;
  // Of a second hypothesis: give up where its minimum is above this, or is the first one's.
  double ruled_out_cost = std::numeric_limits<double>::infinity();
};

// A point of departure. Its cost is that of all points, with the normal equations there, or of some
// of them: then it is a lower bound of what all cost, and there are no equations.
template <int N>
struct ViewStart {
  ViewState state;
  double cost = 0;
  bool has_equations = false;
  NormalEquations<N> equations = {};
};

// N = 6: pose, 7: pose and log focal length.
template <int N>
struct ViewSolution {
  ViewState state;
  double cost = 0;                          // sum of squared whitened residuals
  Eigen::Matrix<double, N, N> information;  // J'J there, upper triangle
  bool converged = false;
};

// The least-squares solution from a start: Gauss-Newton steps, which end good starts in two or
// three evaluations, and where one of them fails Levenberg-Marquardt (ceres::TinySolver) from the
// best point. No value where it is ruled out, or the start is outside of the lens' domain.
template <int N>
std::optional<ViewSolution<N>> solve_view(ViewSums& sums, const ViewStart<N>& start,
                                          const ViewSolverOptions& options = {});

extern template std::optional<ViewSolution<6>> solve_view<6>(ViewSums&, const ViewStart<6>&,
                                                             const ViewSolverOptions&);
extern template std::optional<ViewSolution<7>> solve_view<7>(ViewSums&, const ViewStart<7>&,
                                                             const ViewSolverOptions&);

}  // namespace tagcal::internal
