#include "tagcal/estimate/pose.hpp"

#include <cmath>

#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_hypotheses.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"

namespace tagcal {
using namespace internal;
namespace {

// True for points so near to a line that the data do not exclude a turn by 20 degrees about it. The
// linear covariance does not show this: the likelihood along the turn is flat, and noise decides
// where its minima are.
bool is_turn_about_line_unknown(const PoseProblem& problem, const Lens& lens,
                                const PoseMinima<6>& fit) {
  const ViewPoints view = problem.view();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : view.points) squares += p.cwiseAbs2();
  Eigen::Index along = 0;
  const double length = squares.maxCoeff(&along), width = squares.sum() - length;
  if (width > policy::kNarrowWidth * policy::kNarrowWidth * length) return false;
  ViewResiduals residuals(lens, view);
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  for (const double turn : {policy::kLineTurnRad, -policy::kLineTurnRad}) {
    ViewState state = fit.best().state;
    state.rotation =
        state.rotation * exp_rotation(turn * Eigen::Vector3d::Unit(along)).toRotationMatrix();
    double cost = 0;
    for (const double square : residuals.at(state)) cost += square;
    if (cost - fit.best().cost < policy::kExcludedCost * variance) return true;
  }
  return false;
}

}  // namespace

PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options) {
  RobustPose<6> robust = fit_pose_robustly<6>(correspondences, camera.lens, options);
  PoseEstimate estimate;
  estimate.findings = std::move(robust.findings);
  estimate.status = robust.status;
  if (!robust.fit) return estimate;
  estimate.outliers = std::move(robust.outliers);
  estimate.sigma_px = robust.fit->noise.sigma_px;
  estimate.hypotheses = hypotheses_of<6>(*robust.problem, camera.lens, *robust.fit);
  if (estimate.hypotheses.empty()) {
    estimate.status = Status::degenerate;
    add(estimate.findings, code::degenerate,
        "the points do not determine a pose: their information is singular");
    return estimate;
  }
  if (is_turn_about_line_unknown(*robust.problem, camera.lens, *robust.fit)) {
    estimate.hypotheses.clear();
    estimate.status = Status::degenerate;
    add(estimate.findings, code::degenerate,
        "the points are nearly on a line, and the noise hides the turn about it: use a wider "
        "target");
    return estimate;
  }
  if (estimate.hypotheses.size() > 1) estimate.status = Status::ambiguous;
  if (!robust.fit->best().converged) estimate.status = Status::not_converged;
  return estimate;
}

}  // namespace tagcal
