#pragma once

#include <functional>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The displacement of a point's pixel by the motion of the target in the camera, a twist (rad, m)
// for each row below the middle one. Zero if the lens does not project it.
Eigen::Vector2d row_motion_px(const Camera& camera, const Eigen::Vector3d& point, double row,
                              const Vector6d& motion_per_row);

// The corners where the middle row's time would show them, by the readout of a calibration, which
// it has, and the motion of its poses; views that it rejected get a pose by its lens. Corners keep
// their places in the data set; those that the lens does not project stay as they are. Views
// without neighbours in time have none.
Dataset without_motion(const Dataset& dataset, const std::vector<double>& times_s,
                       const Calibration& calibration);

// A calibration of a film from a rolling shutter, and its readout: `first` itself if no readout is
// seen in it; else, from that calibration on, the corners without_motion are calibrated again until
// the readout stays. `calibrate_once` adds what is left of the readout.
Calibration calibrate_with_readout(
    const Dataset& dataset, const std::vector<double>& times_s, Calibration first,
    const std::function<Calibration(const Dataset&)>& calibrate_once);

}  // namespace tagcal::internal
