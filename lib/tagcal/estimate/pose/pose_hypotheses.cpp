#include "tagcal/estimate/pose/pose_hypotheses.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/profile_likelihood.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// The likelihood of one view, by its pose and, for N = 7, by log f.
template <int N>
class ViewLikelihood {
 public:
  using State = ViewState;
  using Step = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Equations = NormalEquations<N>;
  using Solver = SmallCholesky<N>;

  ViewLikelihood(ViewSums& sums, int rounds) : sums_(sums), rounds_(rounds) {}

  int rounds() const { return rounds_; }

  bool at(const State& state, Equations& equations) { return sums_.at(state, equations); }

  static State stepped(const State& state, const Step& step) { return moved<N>(state, step); }

 private:
  ViewSums& sums_;
  int rounds_;
};

template <int N>
using Profile = ProfileLikelihood<ViewLikelihood<N>>;

template <int N>
Profile<N> profile_of(ViewLikelihood<N>& likelihood, double sigma_px, const PoseMinimum<N>& pose,
                      const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::Matrix<double, N, N> information =
      pose.information.template selfadjointView<Eigen::Upper>();
  return {likelihood, pose.state, pose.cost, sigma_px, information / (sigma_px * sigma_px),
          covariance};
}

constexpr int kRounds = 3;  // numeric: Gauss-Newton steps of a minimisation

constexpr double kFarthestRad = 1;  // numeric: where a profile ends at the latest

// True for the corners of a square about its centre, in their order. By its symmetry the cost rises
// least towards the pose that faces the camera, and one step minimises it.
bool is_square(std::span<const Vector3d> p) {
  if (p.size() != 4) return false;
  const Vector3d turned(-p[0].y(), p[0].x(), 0);
  const double rounding = 1e-6 * turned.norm();  // numeric: rounding of the corners
  return (p[0] + p[2]).norm() < rounding && (p[1] + p[3]).norm() < rounding &&
         std::min((p[1] - turned).norm(), (p[1] + turned).norm()) < rounding;
}

bool may_be_curved(const Matrix6d& covariance) {
  const Matrix3d turn = covariance.topLeftCorner<3, 3>();
  // Bounds of the eigenvalues: the largest of three positive ones is below their sum, and the
  // product of two at most (sum / 2)^2.
  const double sum = turn.trace(), smallest = 4 * turn.determinant() / (sum * sum);
  return !(sum < kCurved * std::sqrt(std::max(0.0, smallest)));
}

// Transforms the covariance of a step (omega, tau, ...) to another origin of the target, which lies
// at `from_origin` from the old one in the camera's axes: it moves by tau - [from_origin] omega.
template <int N>
void change_origin(const Eigen::Vector3d& from_origin, Eigen::Matrix<double, N, N>& covariance) {
  if (from_origin.isZero(0)) return;
  const Eigen::Matrix3d a = -cross_matrix(from_origin);
  covariance.template middleRows<3>(3) += a * covariance.template topRows<3>();
  covariance.template middleCols<3>(3) += covariance.template leftCols<3>() * a.transpose();
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
  hypothesis.covariance = hypothesis.noise_covariance = of_step.template topLeftCorner<6, 6>();
  hypothesis.focal_px = solution.state.focal_px;
  hypothesis.rms_px = rms_px(problem, lens, solution);
  return hypothesis;
}

}  // namespace

Matrix6d widened_covariance(ViewSums& sums, std::span<const Vector3d> points, double sigma_px,
                            const PoseMinimum<6>& pose, const Matrix6d& covariance) {
  if (!may_be_curved(covariance)) return covariance;
  const bool square = is_square(points);
  ViewLikelihood<6> likelihood(sums, square ? 1 : kRounds);
  Profile<6> profile = profile_of(likelihood, sigma_px, pose, covariance);
  Eigen::SelfAdjointEigenSolver<Matrix3d> turns;
  turns.computeDirect(covariance.topLeftCorner<3, 3>());
  const Vector3d sigma = turns.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Vector3d normal = pose.state.rotation.col(2), sight = pose.state.translation;
  const Vector3d facing = normal.dot(sight) * normal.cross(sight);
  for (int i = 2; i > 0 && sigma[i] * sigma[i] > kCurved * sigma[0]; --i) {
    Vector6d function = Vector6d::Zero();
    function.head<3>() = turns.eigenvectors().col(i) / sigma[i];
    const double level = std::copysign(policy::kProfileSigmas, facing.dot(function.head<3>()));
    const Profile<6>::Direction direction{function, covariance * function};
    profile.widen(direction, level, kFarthestRad / sigma[i]);
    if (!square) profile.widen(direction, -level, kFarthestRad / sigma[i]);
  }
  return profile.covariance();
}

Matrix7d widened_covariance(ViewSums& sums, std::span<const Vector3d>, double sigma_px,
                            const PoseMinimum<7>& pose, const Matrix7d& covariance) {
  const double sigma = std::sqrt(covariance(6, 6));
  if (!(sigma > policy::kFocalWellKnown && sigma <= policy::kFocalRefused)) return covariance;
  ViewLikelihood<7> likelihood(sums, kRounds);
  Profile<7> profile = profile_of(likelihood, sigma_px, pose, covariance);
  using Step = ViewLikelihood<7>::Step;
  const Step function = Step::Unit(6) / sigma;
  profile.widen({function, covariance * function}, -policy::kProfileSigmas, policy::kProfileSigmas);
  return profile.covariance();
}

template <int N>
std::vector<PoseHypothesis> hypotheses_of(
    const PoseProblem& problem, const Lens& lens, const PoseMinima<N>& fit,
    Eigen::Matrix<double, N, N, Eigen::DontAlign>* covariance) {
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  ViewSums sums(lens, problem.view());
  std::vector<PoseHypothesis> hypotheses;
  hypotheses.reserve(fit.poses.size());
  double sum = 0;
  double least_cost = 0;
  for (const PoseMinimum<N>& minimum : fit.poses) {
    const PoseMinimum<N> solution = polished<N>(sums, minimum, fit.noise.sigma_px);
    SmallCholesky<N> cholesky;
    if (!cholesky.compute(solution.information)) continue;
    Eigen::Matrix<double, N, N> of_step = widened_covariance(
        sums, problem.view().points, fit.noise.sigma_px, solution, variance * cholesky.inverse());
    hypotheses.push_back(hypothesis_of<N>(problem, lens, solution, of_step));
    if (covariance && hypotheses.size() == 1) *covariance = of_step;
    if (hypotheses.size() == 1) least_cost = solution.cost;
    const double excess = solution.cost - least_cost;
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
