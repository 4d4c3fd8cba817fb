#pragma once

#include "tagcal/estimate/rig/rig_covariance.hpp"
#include "tagcal/estimate/rig/rig_solve.hpp"

namespace tagcal::internal {

// A solved rig with its joint covariance.
struct SolvedRig {
  const RigDataset* data = nullptr;
  const RigState* state = nullptr;
  RigStart start;
  // By the extrinsics and the lenses' free parameters, in the order of `layout`; those of the
  // models of the claims.
  RigLayout layout;
  Eigen::MatrixXd covariance;
};

// The covariance of the pose of camera b in the frame of camera a (`retract`).
Matrix6 covariance_of_pair(const SolvedRig& solved, std::size_t a, std::size_t b);

// Fills in cameras (but for their own calibrations), pairs and instants.
void report_rig(const SolvedRig& solved, RigCalibration& answer);

}  // namespace tagcal::internal
