#include "tagcal/estimate/pose.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/closed_form.hpp"
#include "tagcal/estimate/refine.hpp"
#include "tagcal/estimate/uncertainty.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAssumedSigmaPx = 0.5;
constexpr int kEnoughDegreesOfFreedom = 50;

// Two poses of a plane are told apart where their costs differ by more than this many sigma^2: it
// catches 548 of 549 flips.
constexpr double kAmbiguousCost = 9;

// The other pose that a plane nearly fits under weak perspective: the plane mirrored at the plane
// through its centre across the line of sight (Oberkampf, DeMenthon & Davis, CVIU 1996;
// Schweighofer & Pinz, PAMI 2006). A start for the solver.
Pose flipped(const Pose& camera_from_plane) {
  const Vector3d& centre = camera_from_plane.translation();
  const Matrix3d sight_from_camera =
      Eigen::Quaterniond::FromTwoVectors(centre, Vector3d::UnitZ()).toRotationMatrix();
  Matrix3d turned = sight_from_camera * camera_from_plane.rotation_matrix();
  turned(2, 0) *= -1;
  turned(2, 1) *= -1;
  turned.col(2) = turned.col(0).cross(turned.col(1));
  return {nearest_rotation(sight_from_camera.transpose() * turned), centre};
}

struct PoseProblem {
  ViewProblem view;
  std::vector<Vector3d> points;
  std::vector<Vector3d> rays;
};

std::optional<PoseProblem> prepare(std::span<const Correspondence> correspondences,
                                   const Camera& camera) {
  PoseProblem problem;
  for (const Correspondence& c : correspondences) {
    const std::optional<Ray> ray = ray_in_camera(camera.lens, c.pixel);
    if (!ray || !c.point.allFinite()) return std::nullopt;
    problem.view.correspondences.push_back(c);
    problem.points.push_back(c.point);
    problem.rays.push_back(ray->direction);
  }
  return problem;
}

// Solutions about the centre of the points, so that neither their place nor their unit matters.
std::vector<RefinedPose> solutions(PoseProblem problem, const Camera& camera,
                                   const PoseOptions& options) {
  const PointSpread spread = spread_of(problem.points);
  for (Correspondence& c : problem.view.correspondences)
    c.point = spread.plane_from_target * c.point;
  for (Vector3d& p : problem.points) p = spread.plane_from_target * p;
  std::vector<RefinedPose> found;
  const auto consider = [&](const Pose& start) {
    const auto refined = refine_pose(problem.view, camera.lens, start, options.max_iterations);
    if (!refined) return;
    for (const RefinedPose& other : found)
      if (angle_between_rad(other.camera_from_target, refined->camera_from_target) < 1e-4) return;
    found.push_back(*refined);
  };
  const std::optional<Pose> start = pose_closed_form(problem.points, problem.rays);
  if (!start) return {};
  consider(*start);
  if (spread.shape == PointShape::plane)
    consider(flipped(found.empty() ? *start : found.front().camera_from_target));
  std::sort(found.begin(), found.end(),
            [](const RefinedPose& a, const RefinedPose& b) { return a.cost < b.cost; });
  for (RefinedPose& pose : found)
    pose.camera_from_target = pose.camera_from_target * spread.plane_from_target;
  return found;
}

void choose_sigma(PoseEstimate& estimate, const PoseOptions& options, double cost, int freedom) {
  if (options.sigma_px > 0) {
    estimate.sigma_px = options.sigma_px;
  } else if (freedom >= kEnoughDegreesOfFreedom) {
    estimate.sigma_px = std::sqrt(cost / freedom);
  } else {
    estimate.sigma_px = kAssumedSigmaPx;
    estimate.warnings.push_back(
        "no noise is stated and the residuals are too few to show it: 0.5 px is assumed");
  }
}

PoseEstimate without_answer(Status status, const std::string& reason) {
  PoseEstimate estimate;
  estimate.status = status;
  estimate.warnings.push_back(reason);
  return estimate;
}

}  // namespace

PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options) {
  const std::optional<PoseProblem> problem = prepare(correspondences, camera);
  if (!problem)
    return without_answer(Status::degenerate,
                          "a point is not finite, or a pixel is outside of the lens' domain");
  const PointSpread spread = spread_of(problem->points);
  const std::size_t needed = spread.shape == PointShape::space ? 6 : 4;
  if (spread.shape == PointShape::point || spread.shape == PointShape::line)
    return without_answer(Status::degenerate, "the points lie on a line");
  if (correspondences.size() < needed)
    return without_answer(Status::degenerate, "too few points: " + std::to_string(needed) +
                                                  " are needed, got " +
                                                  std::to_string(correspondences.size()));
  const std::vector<RefinedPose> found = solutions(*problem, camera, options);
  if (found.empty())
    return without_answer(Status::degenerate,
                          "the points do not fix a pose in front of the camera");

  PoseEstimate estimate;
  const int freedom = 2 * static_cast<int>(correspondences.size()) - 6;
  choose_sigma(estimate, options, found.front().cost, freedom);
  const double square = estimate.sigma_px * estimate.sigma_px;
  for (const RefinedPose& pose : found) {
    if (pose.cost - found.front().cost > kAmbiguousCost * square && &pose != &found.front()) break;
    const auto covariance =
        pose_covariance(problem->view, camera.lens, pose.camera_from_target, estimate.sigma_px);
    if (!covariance) continue;
    estimate.hypotheses.push_back(
        {pose.camera_from_target, *covariance,
         std::sqrt(pose.cost / static_cast<double>(correspondences.size())),
         square > 0 ? std::exp(-(pose.cost - found.front().cost) / (2 * square)) : 1.0});
  }
  if (estimate.hypotheses.empty())
    return without_answer(Status::degenerate, "the points do not fix a pose");
  double sum = 0;
  for (const PoseHypothesis& h : estimate.hypotheses) sum += h.probability;
  for (PoseHypothesis& h : estimate.hypotheses) h.probability /= sum;
  if (!found.front().converged)
    estimate.status = Status::not_converged;
  else
    estimate.status = estimate.hypotheses.size() > 1 ? Status::ambiguous : Status::ok;
  return estimate;
}

}  // namespace tagcal
