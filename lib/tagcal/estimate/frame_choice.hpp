#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// What became of a frame of a video or bag.
enum class FrameFate {
  used,
  no_board,  // it shows fewer than four corners
  fast,      // the corners move fast: blur, and rows of different times
  no_pose,   // under the lens of the other frames it has no pose
  nothing,   // it would add next to nothing
};

struct FrameSelection {
  std::vector<FrameFate> fates;   // one a view of the data set
  std::vector<double> speeds_px;  // median over the corners, px/s; 0: not known
  std::vector<std::size_t> used;  // views, ascending
  // Standard deviation of the projection at infinity (px per coordinate, RMS over the image) by the
  // frames used, and by all that are not fast, at the lens of a first calibration; 0 if every frame
  // is used, or there was no such calibration.
  double projection_px = 0;
  double all_px = 0;
};

// Chooses the frames that determine the lens, as select_views does: a calibration of a few frames
// gives the lens, each other frame gets its pose under it, and the frame that reduces the variance
// of the projection most is added, until the next one would reduce it by less than 1 %, or the
// standard deviation is at most `goal_px` (0: no goal). Fast frames are left out, by the corners of
// their neighbours among the views. Up to 60 frames are all used. The answer does not depend on
// chance. If the first calibration has no answer, up to 300 frames are used, evenly. `times_s`: of
// the views, ascending. `options`: those of the calibration.
FrameSelection choose_frames(const Dataset& dataset, std::span<const double> times_s,
                             const CalibrateOptions& options = {}, double goal_px = 0);

}  // namespace tagcal
