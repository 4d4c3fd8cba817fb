#include "tagcal/estimate/pose/focal_profile.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/pose/initial_poses.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr double kFacingSine = 0.1;  // of the angle between normal and line of sight
constexpr double kWellKnown = 0.03, kRefused = 0.1;  // standard deviations of log f
constexpr double kFar = 5;                           // of them
constexpr double kLeastRise = 1;                     // sigma^2

bool is_facing_plane(const PoseProblem& problem, const ViewState& state) {
  return problem.spread().shape == PointShape::plane &&
         state.rotation.col(2).cross(state.translation.normalized()).norm() < kFacingSine;
}

}  // namespace

Matrix7d gain_towards_shorter(const PoseProblem& problem, const Lens& pinhole_lens,
                              const ViewSolution<7>& solution, const Matrix7d& covariance,
                              double sigma_px) {
  const Matrix7d none = Matrix7d::Zero();
  const double linear = std::sqrt(covariance(6, 6));
  if (!(linear > kWellKnown && linear <= kRefused) || !is_facing_plane(problem, solution.state))
    return none;
  const double ratio = std::exp(-kFar * linear);
  const double focal_px = ratio * solution.state.focal_px;
  const Eigen::Vector2d centre = principal_point(pinhole_lens);
  const Lens shorter = pinhole(focal_px, focal_px, centre.x(), centre.y());
  ViewState start = solution.state;
  start.translation.z() *= ratio;
  start.focal_px = 0;
  ViewSums sums(shorter, problem.view());
  const auto there = solve_view<6>(sums, {start});
  SmallCholesky<7> cholesky;
  if (!there || !cholesky.compute(covariance)) return none;
  Eigen::Matrix<double, 7, 1> step;
  step << minus(pose_of(there->state), pose_of(solution.state)), -kFar * linear;
  const double rise = std::max((there->cost - solution.cost) / (sigma_px * sigma_px), kLeastRise);
  const double claimed = step.dot(cholesky.solve(step));
  if (claimed <= rise) return none;
  return (1 / rise - 1 / claimed) * step * step.transpose();
}

}  // namespace tagcal::internal
