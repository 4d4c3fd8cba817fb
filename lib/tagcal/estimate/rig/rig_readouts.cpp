#include "tagcal/estimate/rig/rig_readouts.hpp"

#include "tagcal/estimate/bundle/readout.hpp"
#include "tagcal/estimate/calibration/readout_rounds.hpp"
#include "tagcal/estimate/rig/rig_claims.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The corners of a bundle after a change of the readout.
void displace_rows(const std::vector<double>& times_s, double readout_s, Bundle& bundle) {
  const Camera camera{bundle.lens(), bundle.image_size};
  const auto velocities = velocities_in_time(times_s, bundle.camera_from_target);
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    if (!velocities[v]) continue;
    const Vector6d motion = readout_s / bundle.image_size.height * *velocities[v];
    for (Correspondence& c : bundle.views[v].correspondences.own())
      c.pixel -= row_motion_px(camera, bundle.camera_from_target[v] * c.point, c.pixel.y(), motion);
  }
}

// From one state to another, both with the lenses of the claims.
VectorXd step_between(const RigState& from, const RigState& to, const RigLayout& layout) {
  VectorXd step = VectorXd::Zero(layout.size);
  for (std::size_t c = 0; c < from.cameras.size(); ++c) {
    if (const auto at = layout.pose[c])
      step.segment<6>(*at) = minus(to.poses.camera_from_rig[c], from.poses.camera_from_rig[c]);
    for (std::size_t k = 0; k < from.cameras[c].free_values.size(); ++k)
      step[layout.lens[c] + static_cast<Index>(k)] =
          to.cameras[c].free_values[k] - from.cameras[c].free_values[k];
  }
  for (std::size_t b = 0; b < layout.board.size(); ++b)
    if (const auto at = layout.board[b])
      step.segment<6>(*at) = minus(to.poses.world_from_board[b], from.poses.world_from_board[b]);
  return step;
}

}  // namespace

std::vector<double> film_times(const PlacedViews& views, std::size_t camera) {
  constexpr double kDay = 86400;  // numeric: longer than a film
  std::vector<double> times_s = views.data->cameras[camera].times_s;
  for (std::size_t v = 0; v < times_s.size(); ++v)
    times_s[v] += kDay * static_cast<double>(views.places[camera][v].board);
  return times_s;
}

Eigen::MatrixXd covariance_by_readouts(const RigState& solved, const PlacedViews& views,
                                       const RigLayout& layout, const RigCalibration& rig,
                                       const CalibrateOptions& options) {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(layout.size, layout.size);
  for (std::size_t c = 0; c < solved.cameras.size(); ++c) {
    const std::optional<Readout>& readout = rig.cameras[c].own.readout;
    if (!readout || !readout->is_seen) continue;
    const std::vector<double> of_all = film_times(views, c);
    std::vector<double> times_s;
    for (const std::size_t v : solved.index_of_view[c]) times_s.push_back(of_all[v]);
    RigState moved = solved;
    displace_rows(times_s, readout->sigma_s, moved.cameras[c]);
    solve(moved.cameras, moved.poses, options.max_iterations, options.num_threads);
    const VectorXd step =
        step_between(state_of_claims(solved, rig), state_of_claims(moved, rig), layout);
    covariance += step * step.transpose();
  }
  return covariance;
}

}  // namespace tagcal::internal
