#include "tagcal/estimate/pose.hpp"

#include <cmath>

#include "tagcal/estimate/pose/pose_hypotheses.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Points so near to a line that the turn about it is hardly known. A linear covariance does not
// tell: the likelihood is flat there, with minima where noise has it. So a turn by 20 degrees is
// tried.
bool hides_turn_about_line(const PoseProblem& problem, const Lens& lens, const ViewFit<6>& fit) {
  constexpr double kNarrow = 0.25;   // RMS width, of the length
  constexpr double kTurnRad = 0.35;  // seven times what a known pose may have
  constexpr double kTold = 25;       // sigma^2
  const ViewPoints view = problem.view();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : view.points) squares += p.cwiseAbs2();
  Eigen::Index along = 0;
  const double length = squares.maxCoeff(&along), width = squares.sum() - length;
  if (width > kNarrow * kNarrow * length) return false;
  ViewResiduals residuals(lens, view);
  const double variance = fit.noise.sigma_px * fit.noise.sigma_px;
  for (const double turn : {kTurnRad, -kTurnRad}) {
    ViewState state = fit.best().state;
    state.rotation =
        state.rotation * exp_rotation(turn * Eigen::Vector3d::Unit(along)).toRotationMatrix();
    double cost = 0;
    for (const double square : residuals.at(state)) cost += square;
    if (cost - fit.best().cost < kTold * variance) return true;
  }
  return false;
}

}  // namespace

PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options) {
  AgreeingFit<6> agreeing = fit_agreeing<6>(correspondences, camera.lens, options);
  PoseEstimate estimate;
  estimate.warnings = std::move(agreeing.warnings);
  estimate.status = agreeing.status;
  if (!agreeing.fit) return estimate;
  estimate.outliers = std::move(agreeing.outliers);
  estimate.sigma_px = agreeing.fit->noise.sigma_px;
  estimate.hypotheses = hypotheses_of<6>(*agreeing.problem, camera.lens, *agreeing.fit);
  if (estimate.hypotheses.empty()) {
    estimate.status = Status::degenerate;
    estimate.warnings.emplace_back("the points do not fix a pose");
    return estimate;
  }
  if (hides_turn_about_line(*agreeing.problem, camera.lens, *agreeing.fit)) {
    estimate.hypotheses.clear();
    estimate.status = Status::degenerate;
    estimate.warnings.emplace_back(
        "the points are nearly on a line: the turn about it cannot be told from noise");
    return estimate;
  }
  if (estimate.hypotheses.size() > 1) estimate.status = Status::ambiguous;
  if (!agreeing.fit->best().converged) estimate.status = Status::not_converged;
  return estimate;
}

}  // namespace tagcal
