#include "tagcal/estimate/pose/focal_profile.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/initial_poses.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Matrix7d = Eigen::Matrix<double, 7, 7>;

bool is_facing_plane(const PoseProblem& problem, const ViewState& state) {
  return problem.spread().shape == PointShape::plane &&
         state.rotation.col(2).cross(state.translation.normalized()).norm() < policy::kFacingSine;
}

}  // namespace

Matrix7d shorter_focal_widening(const PoseProblem& problem, const Lens& pinhole_lens,
                                const PoseMinimum<7>& solution, const Matrix7d& covariance,
                                double sigma_px) {
  const Matrix7d none = Matrix7d::Zero();
  const double linear = std::sqrt(covariance(6, 6));
  if (!(linear > policy::kFocalWellKnown && linear <= policy::kFocalRefused) ||
      !is_facing_plane(problem, solution.state))
    return none;
  const double ratio = std::exp(-policy::kFocalProfileSigmas * linear);
  const double focal_px = ratio * solution.state.focal_px;
  const Eigen::Vector2d centre = principal_point(pinhole_lens);
  const Lens shorter = pinhole(focal_px, focal_px, centre.x(), centre.y());
  ViewState start = solution.state;
  start.translation.z() *= ratio;
  start.focal_px = 0;
  ViewSums sums(shorter, problem.view());
  const auto there = refine_pose<6>(sums, {start});
  SmallCholesky<7> cholesky;
  if (!there || !cholesky.compute(covariance)) return none;
  Eigen::Matrix<double, 7, 1> step;
  step << minus(pose_of(there->state), pose_of(solution.state)),
      -policy::kFocalProfileSigmas * linear;
  const double rise = std::max((there->cost - solution.cost) / (sigma_px * sigma_px),
                               policy::kFocalProfileLeastRise);
  const double distance_square = step.dot(cholesky.solve(step));
  if (distance_square <= rise) return none;
  return (1 / rise - 1 / distance_square) * step * step.transpose();
}

}  // namespace tagcal::internal
