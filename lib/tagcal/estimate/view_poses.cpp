#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>

#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

// A view, its outliers and its other corners; no view without a pose.
struct ViewPose {
  std::optional<CalibratedView> view;
  std::string why_not;  // of a view that has corners
  std::vector<Outlier> outliers;
  std::vector<Vector2d> pixels;
  double square_px2 = 0;
  bool has_covariances = false;
};

ViewPose pose_of_view(const View& view, std::size_t index, const Camera& camera,
                      const std::map<CornerId, Eigen::Vector3d>& points,
                      const std::optional<double>& camera_error_px) {
  ViewPose result;
  const ViewCorrespondences seen = view_correspondences(view, points, camera_error_px);
  if (seen.correspondences.empty()) return result;
  const PoseEstimate pose = estimate_pose(seen, camera);
  if (!is_answer(pose.status)) {
    const auto reason = std::ranges::find(pose.findings, Severity::refusal, &Finding::severity);
    result.why_not = reason == pose.findings.end() ? status_name(pose.status) : reason->sentence;
    return result;
  }
  result.has_covariances = !seen.covariance_px2.empty();
  CalibratedView& of_view = result.view.emplace();
  of_view.image = view.image;
  of_view.view = index;
  of_view.camera_from_world = pose.camera_from_target();
  std::vector<bool> is_outlier(seen.correspondences.size());
  for (const std::size_t i : pose.outliers) is_outlier[i] = true;
  for (std::size_t i = 0; i < seen.correspondences.size(); ++i) {
    const Correspondence& c = seen.correspondences[i];
    const auto at = project(camera.lens, of_view.camera_from_world * c.point);
    const double residual = at ? (c.pixel - *at).norm() : std::nan("");
    if (is_outlier[i] || !at) {
      result.outliers.push_back({view.image, seen.ids[i], residual, index, seen.observations[i]});
      continue;
    }
    result.pixels.push_back(c.pixel);
    result.square_px2 += residual * residual;
  }
  of_view.num_corners = static_cast<int>(result.pixels.size());
  if (of_view.num_corners > 0) of_view.rms_px = std::sqrt(result.square_px2 / of_view.num_corners);
  return result;
}

void report_without_pose(const std::vector<ViewPose>& poses, std::vector<Finding>& findings) {
  const auto has_none = [](const ViewPose& pose) { return !pose.why_not.empty(); };
  const auto count = std::ranges::count_if(poses, has_none);
  if (count > 0)
    add(findings, code::view_unusable,
        fmt::format("{} of {} views have no pose under this camera, the first because {}", count,
                    poses.size(), std::ranges::find_if(poses, has_none)->why_not));
}

}  // namespace

ViewPoses poses_of_views(const Dataset& dataset, std::span<const std::size_t> views,
                         const Camera& camera, const std::optional<double>& camera_error_px,
                         std::size_t num_threads) {
  const auto points = points_in_world(dataset.boards);
  std::vector<ViewPose> poses(views.size());
  parallel_for(
      views.size(), threads_for_short_calls(views.size(), num_threads), [&](std::size_t i) {
        poses[i] = pose_of_view(dataset.views[views[i]], views[i], camera, points, camera_error_px);
      });
  ViewPoses result;
  double square_px2 = 0;
  bool needs_noise = false;
  for (ViewPose& pose : poses) {
    if (!pose.view) continue;
    needs_noise |= !pose.has_covariances;
    result.views.push_back(*std::move(pose.view));
    std::ranges::move(pose.outliers, std::back_inserter(result.outliers));
    result.pixels.insert(result.pixels.end(), pose.pixels.begin(), pose.pixels.end());
    square_px2 += pose.square_px2;
  }
  if (!result.pixels.empty())
    result.rms_px = std::sqrt(square_px2 / static_cast<double>(result.pixels.size()));
  result.sigma_px =
      sigma_of_residuals(square_px2, result.pixels.size(), result.views.size(), result.findings);
  result.sigma_from_residuals = result.findings.empty();
  if (!needs_noise) result.findings.clear();
  report_without_pose(poses, result.findings);
  return result;
}

ViewPoses poses_of_views(const Dataset& dataset, const Camera& camera,
                         const std::optional<double>& camera_error_px, std::size_t num_threads) {
  std::vector<std::size_t> all(dataset.views.size());
  std::iota(all.begin(), all.end(), 0);
  return poses_of_views(dataset, all, camera, camera_error_px, num_threads);
}

}  // namespace tagcal
