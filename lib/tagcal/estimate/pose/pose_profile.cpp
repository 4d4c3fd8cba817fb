#include "tagcal/estimate/pose/pose_profile.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

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

double squared_distance(const PoseMinimum<6>& from, const ViewState& to, double variance) {
  const Vector6d step = minus(pose_of(to), pose_of(from.state));
  const Matrix6d information = from.information.selfadjointView<Eigen::Upper>();
  return step.dot(information * step) / variance;
}

constexpr int kRounds = 1;  // numeric: Gauss-Newton steps of a minimisation

bool may_be_curved(const Matrix6d& covariance) {
  const Matrix3d turn = covariance.topLeftCorner<3, 3>();
  // Bounds of the eigenvalues: the largest of three positive ones is below their sum, and the
  // product of two at most (sum / 2)^2.
  const double sum = turn.trace(), smallest = 4 * turn.determinant() / (sum * sum);
  return !(sum < policy::kCurved * std::sqrt(std::max(0.0, smallest)));
}

}  // namespace

bool is_same_minimum(const PoseMinimum<6>& a, const PoseMinimum<6>& b, double sigma_px) {
  constexpr double kLimit = policy::kSameMinimum;
  const double variance = sigma_px * sigma_px;
  return std::abs(a.cost - b.cost) < kLimit * variance &&
         squared_distance(a, b.state, variance) < kLimit &&
         squared_distance(b, a.state, variance) < kLimit;
}

Matrix6d widened_covariance(ViewSums& sums, double sigma_px, const PoseMinimum<6>& pose,
                            const Matrix6d& covariance) {
  if (!may_be_curved(covariance)) return covariance;
  ViewLikelihood<6> likelihood(sums, kRounds);
  Profile<6> profile = profile_of(likelihood, sigma_px, pose, covariance);
  Eigen::SelfAdjointEigenSolver<Matrix3d> turns;
  turns.computeDirect(covariance.topLeftCorner<3, 3>());
  const Vector3d sigma = turns.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  // A turn that makes the plane face the camera raises the cost least.
  const Vector3d normal = pose.state.rotation.col(2), sight = pose.state.translation;
  const Vector3d facing = normal.dot(sight) * normal.cross(sight);
  for (int i = 2; i > 0 && sigma[i] * sigma[i] > policy::kCurved * sigma[0]; --i) {
    Vector6d function = Vector6d::Zero();
    function.head<3>() = turns.eigenvectors().col(i) / sigma[i];
    const double level = std::copysign(policy::kProfileSigmas, facing.dot(function.head<3>()));
    profile.widen({function, covariance * function}, level, policy::kProfileFarthest / sigma[i]);
  }
  return profile.covariance();
}

Matrix7d widened_covariance(ViewSums& sums, double sigma_px, const PoseMinimum<7>& pose,
                            const Matrix7d& covariance) {
  const double sigma = std::sqrt(covariance(6, 6));
  if (!(sigma > policy::kFocalWellKnown && sigma <= policy::kFocalRefused)) return covariance;
  ViewLikelihood<7> likelihood(sums, kRounds);
  Profile<7> profile = profile_of(likelihood, sigma_px, pose, covariance);
  using Step = ViewLikelihood<7>::Step;
  const Step function = Step::Unit(6) / sigma;
  profile.widen({function, covariance * function}, -policy::kProfileSigmas, policy::kProfileSigmas);
  return profile.covariance();
}

}  // namespace tagcal::internal
