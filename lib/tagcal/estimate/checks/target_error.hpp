#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"

namespace tagcal::internal {

// A tag that is not where the target's file says.
struct MisplacedTag {
  int tag_id = 0;
  double shift_mm = 0;  // RMS over its corners
};

// Errors of the target's file on which all views agree.
struct TargetError {
  std::vector<MisplacedTag> tags;  // the worst first
  double share = 0;                // of the inliers' squared residuals that the shifts explain
  double shift_px = 0;             // RMS of that
  bool gross = false;              // so wrong that the calibration is refused
  std::vector<Finding> findings;
};

// Estimates one shift of each corner of the target, the same in all views (in the plane of `board`,
// else in space), by least squares with camera and poses fixed, in units of the corners' noise. It
// is linear, with the scale of a lens without distortion. A corner that was rejected in most views
// is judged by those views. A common scale of all tags about their centres is removed first: ink,
// blooming and detectors cause it, and it does not change the camera. It is a finding of its own
// (policy::kLeastBiasPx). The shifts are a finding if they explain enough of the residuals
// (policy::kTargetShareFound, kTargetShiftFoundPx), or if single tags are outlying
// (policy::kOutlyingTagRatio); `gross` has its own bounds. Returns no value if there is no finding,
// or for fewer than three views. O(corners). `calibration` must have a camera and the views and
// outliers of `input`, in its order; `solved` is its bundle.
std::optional<TargetError> target_error(const CalibrationInput& input,
                                        const Calibration& calibration, const Bundle& solved,
                                        const FlatBoard* board);

}  // namespace tagcal::internal
