#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/rig/rig_start.hpp"

namespace tagcal::internal {

// The place of the parameters of a rig in one vector: the extrinsics of each connected camera but
// the reference (six each), the places of connected boards but the held one (six each), then the
// free parameters of each lens.
struct RigLayout {
  std::vector<std::optional<Eigen::Index>> pose;  // by camera
  std::vector<std::optional<Eigen::Index>> board;
  std::vector<Eigen::Index> lens;  // by camera
  Eigen::Index size = 0;

  RigLayout(const RigState& state, const Connected& connected);

  // The number of parameters of cameras and boards.
  Eigen::Index num_extrinsics() const { return lens.front(); }
};

// The covariance of lenses that were estimated with the extrinsics. The pictures of a camera alone
// give its lens the information S_c; what is known of it is its own calibration's claim (by the
// parameters of its bundle's model), which includes the choice of the model. With H the information
// of the rig, an instant being one sample, the rig adds H - diag(S_c) to the claims:
//   C = ((H - diag(S_c)) / phi + diag(claim_c^-1))^-1,
// with phi the overdispersion between the instants, or the strain of the rig (`strain_of_rig`), if
// that is larger. What the instants do not determine has a very large variance. No value if a view
// does not determine its pose.
std::optional<Eigen::MatrixXd> covariance_of_rig(const RigState& solved, const RigLayout& layout,
                                                 const std::vector<Eigen::MatrixXd>& claims,
                                                 double strain);

// The same for lenses that were held: phi H_ee^-1, and the response to their errors, -H_ee^-1 H_el.
// A claim may be empty: a lens that is exact.
std::optional<Eigen::MatrixXd> covariance_of_extrinsics(const RigState& solved,
                                                        const RigLayout& layout,
                                                        const std::vector<Eigen::MatrixXd>& claims,
                                                        double strain);

}  // namespace tagcal::internal
