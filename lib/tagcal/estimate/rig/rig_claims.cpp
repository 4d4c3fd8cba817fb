#include "tagcal/estimate/rig/rig_claims.hpp"

#include "tagcal/estimate/rig/rig_covariance.hpp"
#include "tagcal/estimate/rig/rig_solve.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// The lenses of the cameras' own calibrations, by the models of their claims.
std::vector<LensClaim> lens_claims(const RigState& of_claims, const RigCalibration& rig) {
  std::vector<LensClaim> claims(of_claims.cameras.size());
  for (std::size_t c = 0; c < claims.size(); ++c) {
    const Calibration& own = rig.cameras[c].own;
    if (!own.claim || !own.claim->model) continue;
    const std::vector<double> values = of_claims.cameras[c].model->free_values(own.camera->lens);
    claims[c] = {Eigen::VectorXd::Map(values.data(), std::ssize(values)), own.claim->covariance};
  }
  return claims;
}

// Moves lenses and places by a step of the rig's parameters, then places all again under these
// lenses.
void move_rig(RigState& state, const RigState& of_claims, const RigLayout& layout,
              const Eigen::VectorXd& step, const CalibrateOptions& options) {
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const Bundle& claimed = of_claims.cameras[c];
    std::vector<double> values = claimed.free_values;
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] += step[layout.lens[c] + static_cast<Index>(k)];
    if (const auto lens = claimed.model->lens(values, claimed.image_size))
      state.cameras[c].free_values = state.cameras[c].model->free_values(*lens);
    if (const auto at = layout.pose[c])
      state.poses.camera_from_rig[c] =
          retract(state.poses.camera_from_rig[c], step.segment<6>(*at));
  }
  solve_places(state, options);
  update_own_poses(state);
}

}  // namespace

RigState state_of_claims(const RigState& answer, const RigCalibration& rig) {
  RigState state = answer;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const std::optional<UncertainCamera>& claim = rig.cameras[c].own.claim;
    if (!claim || !claim->model) continue;
    Bundle& bundle = state.cameras[c];
    const Lens lens = bundle.lens();
    bundle.model = claim->model;
    bundle.free_values = claim->model->free_values(lens);
  }
  return state;
}

std::optional<MatrixXd> joint_covariance(RigState& state, const RigState& of_claims,
                                         const RigLayout& layout, const RigCalibration& rig,
                                         const RigOptions& options) {
  const std::vector<LensClaim> claims = lens_claims(of_claims, rig);
  const double strain = strain_of_rig(state, layout.num_extrinsics());
  std::optional<MatrixXd> covariance;
  if (options.lenses == RigLenses::fixed) {
    covariance = covariance_of_extrinsics(of_claims, layout, claims, strain);
  } else if (const auto claim = claim_of_rig(of_claims, layout, claims, strain)) {
    move_rig(state, of_claims, layout, claim->step, options.calibrate.front());
    covariance = claim->covariance;
  }
  if (covariance) add_scale(state, layout, 1, *covariance);
  return covariance;
}

}  // namespace tagcal::internal
