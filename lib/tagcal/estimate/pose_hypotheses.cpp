#include "tagcal/estimate/pose_hypotheses.hpp"

#include <cmath>
#include <numeric>

#include "tagcal/estimate/frontal.hpp"
#include "tagcal/estimate/small_cholesky.hpp"

namespace tagcal {
namespace {

// The covariance of a step (omega, tau, ...) for another origin of the target, which lies at
// `from_origin` from the old one in the camera's axes: it moves by tau - [from_origin] omega.
template <int N>
void change_origin(const Eigen::Vector3d& from_origin, Eigen::Matrix<double, N, N>& covariance) {
  if (from_origin.isZero(0)) return;
  const Eigen::Matrix3d a = -cross_matrix(from_origin);
  covariance.template middleRows<3>(3) += a * covariance.template topRows<3>();
  covariance.template middleCols<3>(3) += covariance.template leftCols<3>() * a.transpose();
}

// With information that claims no more than there is, and the second pose of a plane that has but
// one minimum where there are two to tell apart. (With the focal length, a plane that may face the
// camera is refused by the rule of the focal length.)
template <int N>
Solutions<ViewSolution<N>, 4> honest(const PoseProblem& problem, const Lens& lens,
                                     const ViewFit<N>& fit) {
  Solutions<ViewSolution<N>, 4> poses = fit.poses;
  if constexpr (N == 6) {
    if (problem.spread().shape != PointShape::plane) return poses;
    const bool both_minima = poses.size() > 1;
    ViewSums sums(lens, problem.view());
    std::optional<ViewSolution<6>> mirrored;
    for (ViewSolution<6>& pose : poses) {
      FrontalPose frontal = unless_frontal(sums, pose, fit.noise.sigma_px, both_minima);
      pose.information = frontal.information;
      mirrored = frontal.mirrored;
    }
    if (mirrored && !both_minima) poses.push_back(*mirrored);
  }
  return poses;
}

// The cost is of whitened residuals; this is of pixels.
template <int N>
double rms_px(const PoseProblem& problem, const Lens& lens, const ViewSolution<N>& solution) {
  double cost = solution.cost;
  if (problem.whitened()) {
    ViewResiduals residuals(lens, {problem.view().points, problem.view().pixels});
    const std::span<const double> squares = residuals.at(solution.state);
    cost = std::accumulate(squares.begin(), squares.end(), 0.0);
  }
  return std::sqrt(cost / static_cast<double>(problem.size()));
}

}  // namespace

template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const ViewFit<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance) {
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  const Pose plane_from_target = problem.spread().plane_from_target_pose();
  const Solutions<ViewSolution<N>, 4> poses = honest<N>(problem, lens, fit);
  std::vector<PoseHypothesis> hypotheses;
  hypotheses.reserve(poses.size());
  double sum = 0;
  for (const ViewSolution<N>& solution : poses) {
    SmallCholesky<N> cholesky;
    if (!cholesky.compute(solution.information)) continue;
    PoseHypothesis& hypothesis = hypotheses.emplace_back();
    const Pose camera_from_plane = pose_of(solution.state);
    hypothesis.camera_from_target = camera_from_plane * plane_from_target;
    Eigen::Matrix<double, N, N> of_step = variance * cholesky.inverse();
    change_origin<N>(hypothesis.camera_from_target.translation() - camera_from_plane.translation(),
                     of_step);
    hypothesis.covariance = of_step.template topLeftCorner<6, 6>();
    if (covariance && hypotheses.size() == 1) *covariance = of_step;
    hypothesis.focal_px = solution.state.focal_px;
    hypothesis.rms_px = rms_px(problem, lens, solution);
    const double excess = solution.cost - fit.best().cost;
    hypothesis.probability = variance > 0 ? std::exp(-excess / (2 * variance)) : 1;
    sum += hypothesis.probability;
  }
  for (PoseHypothesis& h : hypotheses) h.probability /= sum;
  return hypotheses;
}

template std::vector<PoseHypothesis> hypotheses_of<6>(const PoseProblem&, const Lens&,
                                                      const ViewFit<6>&, Matrix6*);
template std::vector<PoseHypothesis> hypotheses_of<7>(const PoseProblem&, const Lens&,
                                                      const ViewFit<7>&, Matrix7*);

}  // namespace tagcal
