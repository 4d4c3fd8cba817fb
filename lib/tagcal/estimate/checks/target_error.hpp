#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/calibration/calibration_input.hpp"

namespace tagcal::internal {

// A tag that is not where its file says.
struct MisplacedTag {
  int tag_id = 0;
  double shift_mm = 0;  // RMS over its corners
};

// What the target's file gets wrong, as far as all views agree on it.
struct TargetError {
  std::vector<MisplacedTag> tags;  // the worst first
  double share = 0;     // of the squared residuals of the inliers, that a shift of each explains
  double shift_px = 0;  // RMS of that
  bool gross = false;   // no calibration against such a target is an answer
  std::vector<std::string> sentences;
};

// Each corner of the target is given one shift, the same in all views (in the plane of `board`,
// else in space), by least squares with camera and poses held, in units of the corners' noise: to
// first order, with the scale of a lens without distortion. Corners that were rejected in most
// views are judged by those views. One scale of all tags about their middles is taken out before:
// ink, the bloom of a sensor and the habits of detectors make it, and it moves no camera. It is
// said where it is beyond five standard deviations and 0.02 px, and nothing else is. A target error
// is said where the shifts explain a fifth of the squared residuals and 1/8 px RMS (boards of paper
// have 0.1 px), or where single tags stand out from the others (five standard deviations, four
// times the median tag); gross is half of them and 1/4 px, or a quarter of all tags. No value where
// nothing stands out, or for fewer than three views. O(corners); `calibration` must have a camera
// and the views and outliers of `input`, in its order.
std::optional<TargetError> target_error(const CalibrationInput& input,
                                        const Calibration& calibration, const FlatBoard* board);

}  // namespace tagcal::internal
