#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/checks/report.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

CalibratedView weak_view(const WeakView& weak, const ViewProblem& problem,
                         const Eigen::Vector2d& centre, double sigma_px) {
  CalibratedView view;
  view.camera_from_world = weak.camera_from_target;
  view.mirrored = weak.mirrored;
  view.scale_px_per_m = weak.scale_px_per_m;
  view.scale_sigma_px_per_m = weak.scale_px_per_m * sigma_px * std::sqrt(weak.covariance(5, 5));
  view.covariance = sigma_px * sigma_px * weak.covariance;
  // The depth is unknown; scale_sigma_px_per_m has the uncertainty of the scale.
  view.covariance.row(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  view.covariance.col(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  view.num_corners = static_cast<int>(problem.correspondences.size());
  const Parallel lens({weak.scale_px_per_m, weak.scale_px_per_m, centre.x(), centre.y()});
  double sum = 0;
  for (const auto& r : residuals_px(problem.correspondences, lens, view.camera_from_world))
    sum += r.squaredNorm();
  view.rms_px = std::sqrt(sum / view.num_corners);
  return view;
}

// Returns true if the residuals of most views are spatially correlated, which perspective causes
// and this model does not have.
bool shows_perspective(const WeakFit& weak) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < weak.views.size(); ++v) {
    const Bundle& bundle = weak.fit.bundle;
    const Eigen::Vector2d centre = image_centre(bundle.image_size);
    const double s = weak.views[v].scale_px_per_m;
    std::vector<Eigen::Vector2d> pixels;
    for (const Correspondence& c : bundle.views[v].correspondences) pixels.push_back(c.pixel);
    count += spatially_correlated(pixels, residuals_px(bundle.views[v].correspondences,
                                                       Parallel({s, s, centre.x(), centre.y()}),
                                                       weak.views[v].camera_from_target));
  }
  return 2 * count > weak.views.size();
}

Status judge_weak(Calibration& c, const WeakFit& weak) {
  const auto without_tilt = std::count_if(c.views.begin(), c.views.end(), [](const auto& view) {
    return !std::isfinite(view.covariance(0, 0));
  });
  if (without_tilt > 0)
    add(c.findings, code::tilt_unknown,
        "in " + std::to_string(without_tilt) +
            " views the tilt has no standard deviation: the board faces the camera");
  if (shows_perspective(weak))
    add(c.findings, code::perspective_seen,
        "the corners show perspective or distortion, which model weak does not have: try --model "
        "auto");
  if (weak.fit.num_inliers() < weak.fit.num_corners / 2) {
    add(c.findings, code::no_consensus,
        "more than half of the corners are outliers of any common answer: check the target file "
        "and the ids of the tags");
    return Status::no_consensus;
  }
  if (degrees_of_freedom(weak.fit.bundle) < policy::kFewestDegreesOfFreedom) {
    add(c.findings, code::degenerate,
        "too few corners for the parameters: " + std::to_string(c.num_corners) + " corners in " +
            std::to_string(c.views.size()) + " views");
    return Status::degenerate;
  }
  return Status::ok;
}

}  // namespace

Calibration report_weak(const WeakFit& weak, const CalibrateOptions& options) {
  const Bundle& bundle = weak.fit.bundle;
  const Eigen::Vector2d centre = image_centre(bundle.image_size);
  Calibration c;
  c.model = "weak";
  c.camera = Camera{Parallel({1, 1, centre.x(), centre.y()}), bundle.image_size};
  c.sigmas.assign(Parallel::kNumParameters, 0.0);
  c.outliers = weak.fit.outliers;
  c.findings = weak.fit.findings;
  choose_sigma(c, weak.fit, options);
  double sum = 0;
  for (std::size_t v = 0; v < weak.views.size(); ++v) {
    c.views.push_back(weak_view(weak.views[v], bundle.views[v], centre, c.sigma_px));
    CalibratedView& view = c.views.back();
    view.image = weak.fit.images[v];
    view.view = weak.fit.views[v];
    sum += view.rms_px * view.rms_px * view.num_corners;
    c.num_corners += view.num_corners;
  }
  c.rms_px = std::sqrt(sum / std::max(1, c.num_corners));
  c.seen = seen_region(bundle);
  c.status = judge_weak(c, weak);
  c.seconds.solve = weak.fit.solve_seconds;
  return c;
}

}  // namespace tagcal::internal
