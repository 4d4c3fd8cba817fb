#include "tagcal/estimate/pose/pose_profile.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Of the variance of the least known turn to the standard deviation of the best known one. (Of a
// tag, whose tilt frontal.hpp has looked at, more is left to it.)
constexpr double kCurved = 0.2, kCurvedOfTag = 0.4;
constexpr double kSteps = 4;        // standard deviations
constexpr double kRisen = 9;        // sigma^2: a walk has come far enough
constexpr double kLeast = 4;        // sigma^2 at which a pose is let in at least
constexpr double kFarthestRad = 1;  // that a turn by some standard deviations means

Vector6d step_between(const ViewState& from, const ViewState& to) {
  return minus(pose_of(to), pose_of(from));
}

ViewState moved(const ViewState& state, const Vector6d& step) {
  ViewState next = state;
  next.rotation = exp_rotation(step.head<3>()).toRotationMatrix() * state.rotation;
  next.translation += step.tail<3>();
  return next;
}

// The Gauss-Newton step among those that leave the value of a linear function of the step.
Vector6d step_across(const SmallCholesky<6>& information, const Vector6d& function,
                     const Vector6d& gradient) {
  const Vector6d p = information.solve(gradient), q = information.solve(function);
  return q * (function.dot(p) / function.dot(q)) - p;
}

// The state of least cost among those that steps across the direction lead to; its cost. Infinite
// outside of the lens' domain.
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
    const ViewState next = moved(state, length * step);
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

double squared_distance(const ViewSolution<6>& from, const ViewState& to, double variance) {
  const Vector6d step = step_between(from.state, to);
  const Matrix6d information = from.information.selfadjointView<Eigen::Upper>();
  return step.dot(information * step) / variance;
}

// Of the least known turns, linear functions with a standard deviation of 1.
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

bool is_one(const ViewSolution<6>& a, const ViewSolution<6>& b, double sigma_px) {
  constexpr double kOne = 0.1;
  const double variance = sigma_px * sigma_px;
  return std::abs(a.cost - b.cost) < kOne * variance &&
         squared_distance(a, b.state, variance) < kOne &&
         squared_distance(b, a.state, variance) < kOne;
}

bool may_be_curved(const Matrix6d& covariance) {
  const Matrix3d turn = covariance.topLeftCorner<3, 3>();
  // The largest of three positive eigenvalues is below their sum, the smallest above their product
  // over the largest that the product of two can be.
  const double sum = turn.trace(), smallest = 4 * turn.determinant() / (sum * sum);
  return !(sum < kCurved * std::sqrt(std::max(0.0, smallest)));
}

PoseProfile::Walk::Walk(const ViewSolution<6>& from_pose, const Matrix6d& linear,
                        const Vector6d& unit)
    : from(from_pose), covariance(linear), direction(unit), step(linear * unit) {
  longest = kFarthestRad / step.head<3>().norm();
}

PoseProfile::PoseProfile(ViewSums& sums, double sigma_px, PosesOfView& poses)
    : sums_(sums), sigma_px_(sigma_px), poses_(poses) {}

Matrix6d PoseProfile::gain(const ViewSolution<6>& pose, const Matrix6d& covariance) {
  Solutions<Vector6d, 4> directions;
  for (const Vector6d& direction : weak_turns(covariance, kCurved))
    if (is_curved({pose, covariance, direction})) directions.push_back(direction);
  if (directions.size() == 2) {
    const Vector6d first = directions[0], second = directions[1];
    directions.push_back((first + second) / std::sqrt(2.0));
    directions.push_back((first - second) / std::sqrt(2.0));
  }
  Matrix6d gain = Matrix6d::Zero();
  for (const Vector6d& direction : directions) {
    const Walk walk(pose, covariance, direction);
    for (const double side : {1.0, -1.0}) go(walk, side, gain);
  }
  return gain;
}

Matrix6d PoseProfile::gain_of_curve(const ViewSolution<6>& pose, const Matrix6d& covariance) {
  Matrix6d gain = Matrix6d::Zero();
  for (const Vector6d& direction : weak_turns(covariance, kCurvedOfTag)) {
    const Walk walk(pose, covariance, direction);
    const double steps = std::min(kSteps, walk.longest), square = steps * steps;
    NormalEquations<6> there;
    SmallCholesky<6> cholesky;
    if (!sums_.at(moved(pose.state, steps * walk.step), there) ||
        !cholesky.compute(there.information))
      continue;
    const Vector6d offset = step_across(cholesky, direction, there.gradient);
    const Matrix6d information = pose.information.selfadjointView<Eigen::Upper>();
    const double claimed = offset.dot(information * offset) / (sigma_px_ * sigma_px_);
    // The same on both sides.
    gain += 2 * (1 / square - 1 / (square + claimed)) * offset * offset.transpose();
  }
  return gain;
}

// Whether the cost does not rise along the straight line as the covariance has it.
bool PoseProfile::is_curved(const Walk& walk) {
  constexpr double kFlat = 0.75, kSteep = 1.3, square = kSteps * kSteps;
  if (walk.longest < kSteps) return true;
  const double variance = sigma_px_ * sigma_px_;
  for (const double length : {kSteps, -kSteps}) {
    NormalEquations<6> there;
    if (!sums_.at(moved(walk.from.state, length * walk.step), there)) return true;
    const double risen = (there.cost - walk.from.cost) / variance;
    if (!(risen > kFlat * square && risen < kSteep * square)) return true;
  }
  return false;
}

void PoseProfile::go(const Walk& walk, double side, Matrix6d& gain) {
  constexpr double kEnough = 0.05;  // sigma^2
  const double variance = sigma_px_ * sigma_px_;
  ViewState state = walk.from.state;
  double gone = 0, risen = 0;
  while (gone < walk.longest && risen < kRisen) {
    const double length = std::min(gone > 0 ? gone : kSteps, walk.longest - gone);
    gone += length;
    state = moved(state, side * length * walk.step);
    const double cost = minimise_across(sums_, walk.direction, kEnough * variance, state);
    risen = (cost - walk.from.cost) / variance;
    if (!std::isfinite(risen)) return;
    const Vector6d step = step_between(walk.from.state, state);
    SmallCholesky<6> cholesky;
    if (!cholesky.compute(walk.covariance + gain)) return;
    const double claimed = step.dot(cholesky.solve(step)), let_in = std::max(risen, kLeast);
    if (claimed > let_in) gain += (1 / let_in - 1 / claimed) * step * step.transpose();
    if (risen < 0.5 * gone * gone) keep_minimum_near(state);
  }
}

void PoseProfile::keep_minimum_near(const ViewState& state) {
  if (poses_.full()) return;
  const auto met = solve_view<6>(sums_, {state});
  if (!met || met->cost > poses_.front().cost + kAmbiguousCost * sigma_px_ * sigma_px_) return;
  for (const ViewSolution<6>& pose : poses_)
    if (is_one(pose, *met, sigma_px_)) return;
  poses_.push_back(*met);
}

}  // namespace tagcal::internal
