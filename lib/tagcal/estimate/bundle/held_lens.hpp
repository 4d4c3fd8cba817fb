#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

// A view is fitted with a lens that is held at its estimate, and the pose has a share of the lens'
// error (consider covariance: Tapley, Schutz & Born, Statistical Orbit Determination, 2004,
// section 6.2).

namespace tagcal::internal {

// How the pose of least squares answers to the lens that it holds.
struct LensResponse {
  // The step (omega, tau) of `retract` and, if the focal length is free, of log f, by the free
  // parameters of the lens' model (6 or 7 x k).
  Eigen::MatrixXd by_lens;
  // What the view itself tells of these parameters, all else free: their information, and the
  // gradient of half the cost.
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// The response for a view whose residuals have a standard deviation of 1. `free_focal`: the fit
// has the mean of log fx and log fy as a parameter. No value if the view does not determine the
// pose. Precondition: the camera has a model.
std::optional<LensResponse> lens_response(const ViewProblem& view, const UncertainCamera& camera,
                                          const Pose& camera_from_target, bool free_focal);

// The second moment of the lens' error after the view, given its covariance before the view.
Eigen::MatrixXd learned_covariance(const LensResponse& response, const Eigen::MatrixXd& prior);

}  // namespace tagcal::internal
