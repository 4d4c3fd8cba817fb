#include "tagcal/estimate/pose/pose_profile.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Vector6d step_between(const ViewState& from, const ViewState& to) {
  return minus(pose_of(to), pose_of(from));
}

ViewState stepped(const ViewState& state, const Vector6d& step) {
  ViewState next = state;
  next.rotation = exp_rotation(step.head<3>()).toRotationMatrix() * state.rotation;
  next.translation += step.tail<3>();
  return next;
}

// The Gauss-Newton step subject to: a linear function of the step keeps its value.
Vector6d step_across(const SmallCholesky<6>& information, const Vector6d& function,
                     const Vector6d& gradient) {
  const Vector6d p = information.solve(gradient), q = information.solve(function);
  return q * (function.dot(p) / function.dot(q)) - p;
}

// Minimises the cost over the steps that leave the linear function `direction` as it is; stops
// where a step would lower the cost by `enough` or less. Returns the cost, infinite outside the
// lens' domain.
double minimise_across(ViewSums& sums, const Vector6d& direction, double enough, ViewState& state) {
  constexpr int kMaxSteps = 8;
  NormalEquations<6> here, there;
  if (!sums.at(state, here)) return std::numeric_limits<double>::infinity();
  double length = 1;
  for (int i = 0; i < kMaxSteps; ++i) {
    SmallCholesky<6> cholesky;
    if (!cholesky.compute(here.information)) break;
    const Vector6d step = step_across(cholesky, direction, here.gradient);
    if (!(-here.gradient.dot(step) > enough)) break;
    const ViewState next = stepped(state, length * step);
    if (!sums.at(next, there) || there.cost > here.cost) {
      length /= 4;
      continue;
    }
    state = next;
    here = there;
    length = 1;
  }
  return here.cost;
}

double squared_distance(const PoseMinimum<6>& from, const ViewState& to, double variance) {
  const Vector6d step = step_between(from.state, to);
  const Matrix6d information = from.information.selfadjointView<Eigen::Upper>();
  return step.dot(information * step) / variance;
}

// Linear functions of the step, with a standard deviation of 1, along the least known turns.
Solutions<Vector6d, 2> weak_turns(const Matrix6d& covariance, double curved) {
  Eigen::SelfAdjointEigenSolver<Matrix3d> turns;
  turns.computeDirect(covariance.topLeftCorner<3, 3>());
  const Vector3d sigma = turns.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  Solutions<Vector6d, 2> directions;
  for (int i = 2; i > 0 && sigma[i] * sigma[i] > curved * sigma[0]; --i) {
    Vector6d direction = Vector6d::Zero();
    direction.head<3>() = turns.eigenvectors().col(i) / sigma[i];
    directions.push_back(direction);
  }
  return directions;
}

}  // namespace

bool is_same_minimum(const PoseMinimum<6>& a, const PoseMinimum<6>& b, double sigma_px) {
  constexpr double kLimit = policy::kSameMinimum;
  const double variance = sigma_px * sigma_px;
  return std::abs(a.cost - b.cost) < kLimit * variance &&
         squared_distance(a, b.state, variance) < kLimit &&
         squared_distance(b, a.state, variance) < kLimit;
}

bool may_be_curved(const Matrix6d& covariance) {
  const Matrix3d turn = covariance.topLeftCorner<3, 3>();
  // Bounds of the eigenvalues: the largest of three positive ones is below their sum, and the
  // product of two at most (sum / 2)^2.
  const double sum = turn.trace(), smallest = 4 * turn.determinant() / (sum * sum);
  return !(sum < policy::kCurved * std::sqrt(std::max(0.0, smallest)));
}

PoseProfile::Path::Path(const PoseMinimum<6>& from_pose, const Matrix6d& linear,
                        const Vector6d& unit)
    : from(from_pose), covariance(linear), direction(unit), step(linear * unit) {
  longest = policy::kProfileFarthestRad / step.head<3>().norm();
}

PoseProfile::PoseProfile(ViewSums& sums, double sigma_px, PosesOfView& poses)
    : sums_(sums), sigma_px_(sigma_px), poses_(poses) {}

Matrix6d PoseProfile::widening(const PoseMinimum<6>& pose, const Matrix6d& covariance) {
  Solutions<Vector6d, 4> directions;
  for (const Vector6d& direction : weak_turns(covariance, policy::kCurved))
    if (is_curved({pose, covariance, direction})) directions.push_back(direction);
  if (directions.size() == 2) {
    const Vector6d first = directions[0], second = directions[1];
    directions.push_back((first + second) / std::sqrt(2.0));
    directions.push_back((first - second) / std::sqrt(2.0));
  }
  Matrix6d widening = Matrix6d::Zero();
  for (const Vector6d& direction : directions) {
    const Path path(pose, covariance, direction);
    for (const double side : {1.0, -1.0}) follow(path, side, widening);
  }
  return widening;
}

Matrix6d PoseProfile::curvature_widening(const PoseMinimum<6>& pose, const Matrix6d& covariance) {
  Matrix6d widening = Matrix6d::Zero();
  for (const Vector6d& direction : weak_turns(covariance, policy::kCurvedOfTag)) {
    const Path path(pose, covariance, direction);
    const double steps = std::min(policy::kProfileSigmas, path.longest), square = steps * steps;
    NormalEquations<6> there;
    SmallCholesky<6> cholesky;
    if (!sums_.at(stepped(pose.state, steps * path.step), there) ||
        !cholesky.compute(there.information))
      continue;
    const Vector6d offset = step_across(cholesky, direction, there.gradient);
    const Matrix6d information = pose.information.selfadjointView<Eigen::Upper>();
    const double excess = offset.dot(information * offset) / (sigma_px_ * sigma_px_);
    // Twice: the other side has the same curvature.
    widening += 2 * (1 / square - 1 / (square + excess)) * offset * offset.transpose();
  }
  return widening;
}

// True if the cost along the linear step is not the parabola that the covariance predicts.
bool PoseProfile::is_curved(const Path& path) {
  constexpr double kSteps = policy::kProfileSigmas, kSquare = kSteps * kSteps;
  if (path.longest < kSteps) return true;
  const double variance = sigma_px_ * sigma_px_;
  for (const double length : {kSteps, -kSteps}) {
    NormalEquations<6> there;
    if (!sums_.at(stepped(path.from.state, length * path.step), there)) return true;
    const double rise = (there.cost - path.from.cost) / variance;
    if (!(rise > policy::kParabolaLow * kSquare && rise < policy::kParabolaHigh * kSquare))
      return true;
  }
  return false;
}

void PoseProfile::follow(const Path& path, double side, Matrix6d& widening) {
  constexpr double kEnough = 0.05;  // numeric: convergence of a minimisation, sigma^2
  const double variance = sigma_px_ * sigma_px_;
  ViewState state = path.from.state;
  double gone = 0, rise = 0;
  while (gone < path.longest && rise < policy::kProfileEnd) {
    const double length = std::min(gone > 0 ? gone : policy::kProfileSigmas, path.longest - gone);
    gone += length;
    state = stepped(state, side * length * path.step);
    const double cost = minimise_across(sums_, path.direction, kEnough * variance, state);
    rise = (cost - path.from.cost) / variance;
    if (!std::isfinite(rise)) return;
    const Vector6d step = step_between(path.from.state, state);
    SmallCholesky<6> cholesky;
    if (!cholesky.compute(path.covariance + widening)) return;
    const double distance_square = step.dot(cholesky.solve(step));
    const double wanted = std::max(rise, policy::kProfileLeastRise);
    if (distance_square > wanted)
      widening += (1 / wanted - 1 / distance_square) * step * step.transpose();
    if (rise < policy::kOtherMinimumRise * gone * gone) keep_minimum_near(state);
  }
}

void PoseProfile::keep_minimum_near(const ViewState& state) {
  if (poses_.full()) return;
  const auto found = refine_pose<6>(sums_, {state});
  if (!found || found->cost > poses_.front().cost + policy::kAmbiguousCost * sigma_px_ * sigma_px_)
    return;
  for (const PoseMinimum<6>& pose : poses_)
    if (is_same_minimum(pose, *found, sigma_px_)) return;
  poses_.push_back(*found);
}

}  // namespace tagcal::internal
