#include "tagcal/estimate/pose.hpp"

#include <cmath>

#include "tagcal/estimate/agreeing_fit.hpp"
#include "tagcal/estimate/pose_hypotheses.hpp"

namespace tagcal {

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
    estimate.warnings.push_back("the points do not fix a pose");
    return estimate;
  }
  if (estimate.hypotheses.size() > 1) estimate.status = Status::ambiguous;
  if (!agreeing.fit->best().converged) estimate.status = Status::not_converged;
  return estimate;
}

}  // namespace tagcal
