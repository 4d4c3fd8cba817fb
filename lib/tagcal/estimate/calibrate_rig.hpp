#pragma once

#include "tagcal/estimate/rig_types.hpp"

namespace tagcal {

// Calibrates cameras on one rigid body that see the same boards, from the instants at which they
// took their pictures. Steps:
//   1. each camera's own calibration, as `calibrate`;
//   2. the order of the corners of boards that look the same turned by half a turn;
//   3. extrinsics along the graph of common instants, by the least median of squares;
//   4. clocks, and cameras that moved between two instants;
//   5. one bundle of all cameras, and instants that contradict it are rejected;
//   6. the joint covariance.
// Statuses: ok; not_connected; not_synchronous; no_consensus, if most of the instants of a camera
// contradict the others; and those of `calibrate`, with the camera's name in a finding. Throws
// Error for a rig without cameras, a reference or a list of known cameras that does not fit it,
// instants whose views do not exist, boards that differ between the cameras, and as `calibrate`.
RigCalibration calibrate_rig(const RigDataset& rig, const RigOptions& options = {});

}  // namespace tagcal
