#include "tagcal/estimate/calibration/readout_rounds.hpp"

#include <cmath>

#include "tagcal/estimate/bundle/readout.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMaxReadoutRounds = 10;   // numeric: of Gauss-Newton steps
constexpr double kReadoutChange = 0.1;  // numeric: standard deviations, which change no claim

// The corners as the middle row's time would show them.
void take_motion_out(const Camera& camera, const std::map<CornerId, Eigen::Vector3d>& points,
                     const Pose& camera_from_world, const Vector6d& motion_per_row, View& view) {
  const double middle_row = image_centre(camera.image_size).y();
  std::vector<Observation> still;
  for (Observation& o : view.observations) {
    const Eigen::Vector3d point = camera_from_world * points.at(o.id);
    const Pose moved = exp_pose((o.pixel.y() - middle_row) * motion_per_row);
    const auto here = project(camera.lens, point), there = project(camera.lens, moved * point);
    if (!here || !there) continue;
    o.pixel -= *there - *here;
    still.push_back(o);
  }
  view.observations = std::move(still);
}

Dataset without_motion(const Dataset& dataset, const std::vector<double>& times_s,
                       const Calibration& calibration, double readout_s) {
  std::vector<double> times;
  std::vector<Pose> poses;
  for (const CalibratedView& view : calibration.views) {
    times.push_back(times_s[view.view]);
    poses.push_back(view.camera_from_world);
  }
  const auto velocities = velocities_in_time(times, poses);
  Dataset still = dataset;
  for (View& view : still.views) view.observations.clear();
  const auto points = points_in_world(dataset.boards);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!velocities[i]) continue;
    const std::size_t v = calibration.views[i].view;
    still.views[v] = dataset.views[v];
    take_motion_out(*calibration.camera, points, poses[i],
                    readout_s / dataset.image_size.height * *velocities[i], still.views[v]);
  }
  return still;
}

}  // namespace

Calibration calibrate_with_readout(
    const Dataset& dataset, const std::vector<double>& times_s, Calibration first,
    const std::function<Calibration(const Dataset&)>& calibrate_once) {
  Calibration result = std::move(first);
  if (!result.readout || !result.readout->is_seen) return result;
  double readout_s = 0;
  for (int round = 1; result.readout; ++round) {
    const double step_s = result.readout->seconds;
    readout_s += step_s;
    result.readout->seconds = readout_s;
    result.readout->is_seen = true;
    if (std::abs(step_s) < kReadoutChange * result.readout->sigma_s || round == kMaxReadoutRounds)
      break;
    result = calibrate_once(without_motion(dataset, times_s, result, readout_s));
  }
  return result;
}

}  // namespace tagcal::internal
