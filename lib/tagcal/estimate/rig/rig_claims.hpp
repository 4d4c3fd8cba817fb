#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/estimate/rig/rig_covariance.hpp"

namespace tagcal::internal {

// The state with the lenses' parameters as those of the models of their claims.
RigState state_of_claims(const RigState& answer, const RigCalibration& rig);

// The joint covariance of extrinsics and lenses. Lenses that are estimated get the answer that is
// the best by their claims and the rig. No value if a view does not determine its pose.
std::optional<Eigen::MatrixXd> joint_covariance(RigState& state, const RigState& of_claims,
                                                const RigLayout& layout, const RigCalibration& rig,
                                                const RigOptions& options);

}  // namespace tagcal::internal
