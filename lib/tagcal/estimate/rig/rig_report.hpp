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

// Fills in cameras (but for their own calibrations), pairs and instants.
void report_rig(const SolvedRig& solved, RigCalibration& answer);

}  // namespace tagcal::internal
