#include "tagcal/estimate/pose/near_frontal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/small_cholesky.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

// The tilt of a plane: the axis and the sine of the turn that makes it face the line of sight, and
// the normal and the line of sight, both towards the camera.
struct Tilt {
  explicit Tilt(const ViewState& state) : normal(state.rotation.col(2)) {
    if (normal.dot(state.translation) > 0) normal = -normal;
    sight = -state.translation.normalized();
    const Vector3d cross = normal.cross(sight);
    sine = cross.norm();
    if (sine > 0) axis = cross / sine;
  }

  double angle() const { return std::atan2(sine, normal.dot(sight)); }

  Vector3d normal, sight, axis = Vector3d::Zero();
  double sine;
};

double variance_along(const SmallCholesky<6>& cholesky, const Vector3d& direction) {
  Vector6d w = Vector6d::Zero();
  w.head<3>() = direction;
  return w.dot(cholesky.solve(w));
}

// The best pose of a given tilt, by one Gauss-Newton step.
struct TurnedPose {
  ViewState state;
  NormalEquations<6> equations;                           // before the step
  double cost = std::numeric_limits<double>::infinity();  // after it; infinite out of the domain
};

TurnedPose turned_pose(ViewSums& sums, const ViewState& from, const Vector3d& turn) {
  TurnedPose pose{from, {}};
  pose.state.rotation = exp_rotation(turn).toRotationMatrix() * from.rotation;
  if (!sums.at(pose.state, pose.equations)) return pose;
  // Steps keep the tilt unless they turn about an axis across the line of sight.
  const Vector3d sight = from.translation.normalized(), across = sight.unitOrthogonal();
  Eigen::Matrix<double, 6, 4> keep = Eigen::Matrix<double, 6, 4>::Zero();
  keep.topLeftCorner<3, 1>() = sight;
  keep.bottomRightCorner<3, 3>() << sight, across, sight.cross(across);
  const Eigen::Matrix<double, 6, 6> full =
      pose.equations.information.selfadjointView<Eigen::Upper>();
  SmallCholesky<4> cholesky;
  if (!cholesky.compute(keep.transpose() * full * keep)) return pose;
  const Eigen::Matrix<double, 4, 1> gradient = keep.transpose() * pose.equations.gradient;
  const Eigen::Matrix<double, 4, 1> step = -cholesky.solve(gradient);
  pose.cost = pose.equations.cost + gradient.dot(step);
  const Vector6d move = keep * step;
  pose.state.rotation = exp_rotation(move.head<3>()).toRotationMatrix() * pose.state.rotation;
  pose.state.translation += move.tail<3>();
  return pose;
}

}  // namespace

NearFrontalPose near_frontal_pose(ViewSums& sums, const PoseMinimum<6>& solution, double sigma_px,
                                  bool both_minima) {
  NearFrontalPose result{solution.information, std::nullopt};
  const double variance = sigma_px * sigma_px;
  const Tilt tilted(solution.state);
  SmallCholesky<6> at_solution;
  if (!(tilted.sine > 0) || !at_solution.compute(solution.information)) return result;
  const Vector3d axis = tilted.axis;
  const double variance_there = variance_along(at_solution, axis);
  // The linear distance to the facing plane is at most twice the true one.
  if (tilted.sine * tilted.sine > 4 * policy::kExcludedCost * variance * variance_there)
    return result;
  const double tilt = tilted.angle();
  const Vector3d turn = tilt * axis;

  const TurnedPose facing = turned_pose(sums, solution.state, turn);
  const double facing_excess = (facing.cost - solution.cost) / variance;
  if (!(facing_excess <= policy::kExcludedCost)) return result;
  TurnedPose mirrored{solution.state, {}};
  if (!both_minima) mirrored = turned_pose(sums, solution.state, 2 * turn);
  const double mirrored_excess = (mirrored.cost - solution.cost) / variance;  // may be infinite

  // Lower bounds of the variance of the tilt.
  const double a1 = 1 / (variance * variance_there);
  SmallCholesky<6> at_facing;
  const double a0 = at_facing.compute(facing.equations.information)
                        ? 1 / (variance * variance_along(at_facing, axis))
                        : 0;
  const double b = std::max(0.0, a1 - a0) / (tilt * tilt);
  const double spanned = 2 / (a0 + std::sqrt(a0 * a0 + 4 * b));  // s^2 of b s^4 + a0 s^2 = 1
  const double wanted = std::max({spanned, tilt * tilt / std::max(1.0, facing_excess),
                                  4 * tilt * tilt / std::max(1.0, mirrored_excess)});
  // Between the two poses the information is nearly linear in the squared tilt.
  constexpr double kLeastShare = 1e-3;  // numeric: keeps the information positive definite
  const double share = a1 > a0 ? std::clamp((1 / wanted - a0) / (a1 - a0), kLeastShare, 1.0) : 1.0;
  result.information = share * solution.information + (1 - share) * facing.equations.information;
  if (mirrored_excess < policy::kAmbiguousCost && 4 * tilt * tilt * a1 > 4 * policy::kAmbiguousCost)
    result.mirrored = PoseMinimum<6>{
        mirrored.state, mirrored.cost,
        share * mirrored.equations.information + (1 - share) * facing.equations.information, true};
  return result;
}

}  // namespace tagcal::internal
