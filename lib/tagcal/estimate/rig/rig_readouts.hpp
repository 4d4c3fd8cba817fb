#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/estimate/rig/rig_covariance.hpp"

// Rolling shutters of a rig's cameras, whose readouts their own calibrations estimate.

namespace tagcal::internal {

// The stamps of a camera's views. Those of each board have their own day: its views are no
// neighbours of another one's.
std::vector<double> film_times(const PlacedViews& views, std::size_t camera);

// The part of the covariance of the rig's parameters that the readouts cause: the sum of s s' over
// those that were taken out of the corners, with s the step of the solved bundle's answer by one
// standard deviation of the readout, which another bundle finds.
Eigen::MatrixXd covariance_by_readouts(const RigState& solved, const PlacedViews& views,
                                       const RigLayout& layout, const RigCalibration& rig,
                                       const CalibrateOptions& options);

}  // namespace tagcal::internal
