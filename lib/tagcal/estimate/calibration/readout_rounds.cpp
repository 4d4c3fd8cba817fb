#include "tagcal/estimate/calibration/readout_rounds.hpp"

#include <cmath>

#include "tagcal/estimate/bundle/readout.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMaxReadoutRounds = 10;   // numeric: of Gauss-Newton steps
constexpr double kReadoutChange = 0.1;  // numeric: standard deviations, which change no claim

}  // namespace

Eigen::Vector2d row_motion_px(const Camera& camera, const Eigen::Vector3d& point, double row,
                              const Vector6d& motion_per_row) {
  const double rows = row - image_centre(camera.image_size).y();
  const auto here = project(camera.lens, point);
  const auto there = project(camera.lens, exp_pose(rows * motion_per_row) * point);
  if (!here || !there) return Eigen::Vector2d::Zero();
  return *there - *here;
}

Dataset without_motion(const Dataset& dataset, const std::vector<double>& times_s,
                       const Calibration& calibration) {
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
    const Vector6d motion =
        calibration.readout->seconds / dataset.image_size.height * *velocities[i];
    for (Observation& o : still.views[v].observations)
      if (const auto point = points.find(o.id); point != points.end())
        o.pixel -=
            row_motion_px(*calibration.camera, poses[i] * point->second, o.pixel.y(), motion);
  }
  return still;
}

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
    result = calibrate_once(without_motion(dataset, times_s, result));
  }
  return result;
}

}  // namespace tagcal::internal
