#include "tagcal/estimate/pose/pose_hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_profile.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

// Transforms the covariance of a step (omega, tau, ...) to another origin of the target, which lies
// at `from_origin` from the old one in the camera's axes: it moves by tau - [from_origin] omega.
template <int N>
void change_origin(const Eigen::Vector3d& from_origin, Eigen::Matrix<double, N, N>& covariance) {
  if (from_origin.isZero(0)) return;
  const Eigen::Matrix3d a = -cross_matrix(from_origin);
  covariance.template middleRows<3>(3) += a * covariance.template topRows<3>();
  covariance.template middleCols<3>(3) += covariance.template leftCols<3>() * a.transpose();
}

// The minima of a fit without duplicates.
template <int N>
Solutions<PoseMinimum<N>, 4> distinct_minima(const PoseMinima<N>& fit) {
  if constexpr (N == 7) {
    return fit.poses;
  } else {
    Solutions<PoseMinimum<N>, 4> poses;
    for (const PoseMinimum<N>& pose : fit.poses)
      if (std::none_of(poses.begin(), poses.end(), [&](const PoseMinimum<N>& other) {
            return is_same_minimum(other, pose, fit.noise.sigma_px);
          }))
        poses.push_back(pose);
    return poses;
  }
}

// RMS of the residuals in pixels, not whitened.
template <int N>
double rms_px(const PoseProblem& problem, const Lens& lens, const PoseMinimum<N>& solution) {
  double cost = solution.cost;
  if (problem.whitened()) {
    ViewResiduals residuals(lens, {problem.view().points, problem.view().pixels});
    const std::span<const double> squares = residuals.at(solution.state);
    cost = std::accumulate(squares.begin(), squares.end(), 0.0);
  }
  return std::sqrt(cost / static_cast<double>(problem.size()));
}

// Returns the solution in the target's frame. `of_step` is the covariance of the solution's step,
// and is transformed to that frame.
template <int N>
PoseHypothesis hypothesis_of(const PoseProblem& problem, const Lens& lens,
                             const PoseMinimum<N>& solution, Eigen::Matrix<double, N, N>& of_step) {
  PoseHypothesis hypothesis;
  const Pose camera_from_plane = pose_of(solution.state);
  hypothesis.camera_from_target = camera_from_plane * problem.spread().plane_from_target_pose();
  change_origin<N>(hypothesis.camera_from_target.translation() - camera_from_plane.translation(),
                   of_step);
  hypothesis.covariance = of_step.template topLeftCorner<6, 6>();
  hypothesis.focal_px = solution.state.focal_px;
  hypothesis.rms_px = rms_px(problem, lens, solution);
  return hypothesis;
}

}  // namespace

template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const PoseMinima<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance) {
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  ViewSums sums(lens, problem.view());
  const auto poses = distinct_minima<N>(fit);
  std::vector<PoseHypothesis> hypotheses;
  hypotheses.reserve(poses.size());
  double sum = 0;
  for (const PoseMinimum<N>& solution : poses) {
    SmallCholesky<N> cholesky;
    if (!cholesky.compute(solution.information)) continue;
    Eigen::Matrix<double, N, N> of_step =
        widened_covariance(sums, fit.noise.sigma_px, solution, variance * cholesky.inverse());
    hypotheses.push_back(hypothesis_of<N>(problem, lens, solution, of_step));
    if (covariance && hypotheses.size() == 1) *covariance = of_step;
    const double excess = solution.cost - fit.best().cost;
    hypotheses.back().probability = std::exp(-excess / (2 * variance));
    sum += hypotheses.back().probability;
  }
  for (PoseHypothesis& h : hypotheses) h.probability /= sum;
  return hypotheses;
}

template std::vector<PoseHypothesis> hypotheses_of<6>(const PoseProblem&, const Lens&,
                                                      const PoseMinima<6>&, Matrix6*);
template std::vector<PoseHypothesis> hypotheses_of<7>(const PoseProblem&, const Lens&,
                                                      const PoseMinima<7>&, Matrix7*);

}  // namespace tagcal::internal
