#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

// The start of a check's free fit (free_fit.hpp).
namespace tagcal::internal {

// A view with all its corners; the bundle has its inliers.
struct WholeView {
  std::size_t index = 0;     // in the data set
  std::optional<Pose> pose;  // before the known camera, at the start
  std::vector<Correspondence> corners;
  std::vector<Matrix2> covariance_px2;  // of the corners; the identity if they have none
  std::vector<std::uint8_t> inlier;
};

// The views of one camera with their poses by the known lens. The noise of the poses is that of
// their own residuals, which a change of the camera may have made larger than any stated one.
std::vector<WholeView> whole_views(const CalibrationInput& input, const Camera& camera,
                                   std::vector<Finding>& findings);

// The known camera, free about what is known of it, without views.
Bundle free_bundle(const UncertainCamera& known, const Dataset& data);

}  // namespace tagcal::internal
