#include "tagcal/estimate/pose.hpp"

#include <cmath>

#include "tagcal/estimate/pose_fit.hpp"
#include "tagcal/estimate/small_cholesky.hpp"

namespace tagcal {
namespace {

PoseEstimate without_answer(Status status, const std::string& reason) {
  PoseEstimate estimate;
  estimate.status = status;
  estimate.warnings.push_back(reason);
  return estimate;
}

// Why a problem has no answer; empty: it may have one.
std::string defect(const PoseProblem& problem) {
  if (!problem.finite()) return "a point or a pixel is not finite";
  if (problem.size() < 4)
    return "too few points: 4 are needed, got " + std::to_string(problem.size());
  const PointShape shape = problem.spread().shape;
  if (shape == PointShape::point) return "the points are all at one place";
  if (shape == PointShape::line) return "the points lie on a line";
  return {};
}

// The hypotheses of a fit with their covariance and odds.
PoseEstimate report(const PoseProblem& problem, const PoseFit& fit) {
  PoseEstimate estimate;
  estimate.sigma_px = fit.noise.sigma_px;
  const double square = fit.noise.sigma_px * fit.noise.sigma_px;
  double sum = 0;
  estimate.hypotheses.reserve(fit.poses.size());
  for (const ViewSolution<6>& solution : fit.poses) {
    SmallCholesky<6> cholesky;
    if (!cholesky.compute(solution.information)) continue;
    PoseHypothesis hypothesis;
    hypothesis.camera_from_target = pose_of(solution.state);
    hypothesis.covariance = square * cholesky.inverse();
    hypothesis.rms_px = std::sqrt(solution.cost / static_cast<double>(problem.size()));
    const double excess = solution.cost - fit.poses.front().cost;
    hypothesis.probability = square > 0 ? std::exp(-excess / (2 * square)) : 1;
    sum += hypothesis.probability;
    estimate.hypotheses.push_back(problem.in_target_frame(hypothesis));
  }
  if (estimate.hypotheses.empty())
    return without_answer(Status::degenerate, "the points do not fix a pose");
  for (PoseHypothesis& h : estimate.hypotheses) h.probability /= sum;
  estimate.status = estimate.hypotheses.size() > 1 ? Status::ambiguous : Status::ok;
  if (!fit.poses.front().converged) estimate.status = Status::not_converged;
  if (fit.noise.assumed)
    estimate.warnings.push_back(
        "no noise is stated and the residuals are too few to show it: 0.5 px is assumed");
  return estimate;
}

}  // namespace

PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options) {
  const PoseProblem problem(correspondences, options);
  if (const std::string reason = defect(problem); !reason.empty())
    return without_answer(Status::degenerate, reason);
  const std::optional<PoseFit> fit = fit_pose(problem, camera.lens, options);
  if (!fit)
    return without_answer(Status::degenerate,
                          "the points do not fix a pose in front of the camera");
  return report(problem, *fit);
}

}  // namespace tagcal
