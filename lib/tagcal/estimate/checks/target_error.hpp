#pragma once

#include <optional>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Errors of the target's file on which all views agree.
struct TargetError {
  double share = 0;    // of the inliers' squared residuals that the shifts explain
  bool gross = false;  // so wrong that the calibration is refused
  std::optional<Finding> tags_misplaced;
  std::optional<Finding> tag_scale;
};

// Estimates one shift of each corner of the target, the same in all views (in the plane of the
// bundle's board, else in space), by a linear step of least squares with camera and poses fixed, in
// units of the corners' noise. A corner that was rejected in most views is judged by those views. A
// common scale of all tags about their centres is removed first: ink, blooming and detectors cause
// it, and it does not change the camera. It is a finding of its own (policy::kLeastSigmaPx). The
// shifts are a finding if they explain enough of the residuals (policy::kTargetShareFound,
// kTargetShiftFoundPx), or if single tags are outlying (policy::kOutlierSigmas); `gross` has its
// own bounds. Returns no value if there is no finding, or for fewer than three views. O(corners).
// `fit`: to the input.
std::optional<TargetError> target_error(const CalibrationInput& input, const CalibrationFit& fit);

}  // namespace tagcal::internal
