#include "tagcal/estimate/checks/weak_checks.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

// A board that faces the camera moves its corners with the square of its tilt only. The two
// mirrored poses then merge, and a linear covariance about one of them says nothing of the other.
bool is_tilt_unknown(const CalibratedView& view) {
  const double variance = view.covariance.diagonal().head<2>().maxCoeff();
  if (!std::isfinite(variance)) return true;
  if (!view.mirrored) return false;
  const double between = angle_between_rad(view.camera_from_world, *view.mirrored);
  return between <= policy::kProfileSigmas * std::sqrt(variance);
}

}  // namespace

std::optional<Finding> check_corner_count(const CalibrationFit& fit) {
  if (degrees_of_freedom(fit.bundle) >= policy::kFewestDegreesOfFreedom) return std::nullopt;
  return finding(code::degenerate,
                 "too few corners for the parameters: " + std::to_string(fit.num_inliers()) +
                     " corners in " + std::to_string(fit.used.size()) + " views");
}

std::optional<Finding> check_tilts(const Calibration& answer) {
  const auto count = std::ranges::count_if(answer.views, is_tilt_unknown);
  if (count == 0) return std::nullopt;
  return finding(
      code::tilt_unknown,
      "in " + std::to_string(count) +
          " views the board faces the camera, and the corners fit its two mirrored poses "
          "alike: the standard deviation of its tilt does not hold there");
}

std::optional<Finding> check_perspective(const CalibrationFit& fit) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < fit.used.size(); ++v) {
    const auto& corners = fit.bundle.views[v].correspondences;
    std::vector<Eigen::Vector2d> seen;
    for (const Correspondence& c : corners) seen.push_back(c.pixel);
    count += spatially_correlated(
        seen, residuals_px(corners, fit.lens(fit.used[v]), fit.bundle.camera_from_target[v]));
  }
  if (2 * count <= fit.used.size()) return std::nullopt;
  return finding(code::perspective_seen,
                 "the corners show perspective or distortion, which model weak does not have: try "
                 "--model auto");
}

}  // namespace tagcal::internal
