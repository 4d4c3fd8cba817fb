#include "tagcal/estimate/calibration/readout_rounds.hpp"

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/readout.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMaxReadoutRounds = 10;   // numeric: of Gauss-Newton steps
constexpr double kReadoutChange = 0.1;  // numeric: standard deviations, which change no claim

using Points = std::map<CornerId, Eigen::Vector3d>;

// The pose of a rejected view, by a known lens: a large motion of the rows is a reason to reject
// right views.
std::optional<Pose> pose_by_lens(const View& view, const Points& points, const Lens& lens) {
  std::vector<Correspondence> corners;
  for (const Observation& o : view.observations)
    if (const auto point = points.find(o.id); point != points.end())
      corners.push_back({point->second, o.pixel});
  const RobustPose<6> pose = fit_pose_robustly<6>(corners, lens, {});
  return pose.fit ? std::optional(pose.camera_from_target()) : std::nullopt;
}

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
  const Points points = points_in_world(dataset.boards);
  std::vector<std::size_t> views;
  std::vector<bool> is_used(dataset.views.size());
  std::vector<double> times;
  std::vector<Pose> poses;
  for (const CalibratedView& view : calibration.views) {
    views.push_back(view.view);
    is_used[view.view] = true;
    times.push_back(times_s[view.view]);
    poses.push_back(view.camera_from_world);
  }
  // A rejected view may be wrong, so the velocities of the others do not use its pose.
  auto velocities = velocities_in_time(times, poses);
  for (std::size_t v = 0; v < dataset.views.size(); ++v) {
    const auto pose = is_used[v] ? std::nullopt
                                 : pose_by_lens(dataset.views[v], points, calibration.camera->lens);
    if (!pose) continue;
    views.push_back(v);
    times.push_back(times_s[v]);
    poses.push_back(*pose);
  }
  const auto of_all = velocities_in_time(times, poses);
  velocities.insert(velocities.end(), of_all.begin() + std::ssize(velocities), of_all.end());
  Dataset still = dataset;
  for (View& view : still.views) view.observations.clear();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!velocities[i]) continue;
    const std::size_t v = views[i];
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
