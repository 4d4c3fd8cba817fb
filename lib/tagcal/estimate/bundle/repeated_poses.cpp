#include "tagcal/estimate/bundle/repeated_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class SamePose {
 public:
  explicit SamePose(const Bundle& bundle)
      : bundle_(bundle),
        lens_(bundle.lens()),
        radius_px_(policy::kSamePose *
                   std::hypot(bundle.image_size.width, bundle.image_size.height)) {
    // A point of the target in the directions that the views see it in: far apart for most pairs.
    const double focal_px = parameters(lens_).front();
    const Vector3d point = bundle.views.front().correspondences[0].point;
    for (const Pose& pose : bundle.camera_from_target)
      seen_.push_back(focal_px * (pose * point).normalized());
  }

  bool operator()(std::size_t a, std::size_t b) const {
    constexpr double kFar = 4;  // numeric: radii, beyond which no point of the board is within one
    if ((seen_[a] - seen_[b]).squaredNorm() > kFar * kFar * radius_px_ * radius_px_) return false;
    constexpr std::size_t kEnough = 8;  // numeric: points spread over the view
    const auto& points = bundle_.views[a].correspondences;
    double square = 0;
    const std::vector<std::size_t> tested = spread_indices(points.size(), kEnough);
    for (const std::size_t i : tested) {
      const auto by_a = pixel(a, points[i].point), by_b = pixel(b, points[i].point);
      if (!by_a || !by_b) return false;
      square += (*by_a - *by_b).squaredNorm();
    }
    return square <= radius_px_ * radius_px_ * static_cast<double>(tested.size());
  }

 private:
  std::optional<Vector2d> pixel(std::size_t view, const Vector3d& point) const {
    return project(lens_, bundle_.camera_from_target[view] * point);
  }

  const Bundle& bundle_;
  Lens lens_;
  double radius_px_;
  std::vector<Vector3d> seen_;
};

using Coordinates = std::array<double, 3>;

// The residuals of a view by the points of the target.
std::map<Coordinates, Vector2d> residuals_by_point(const Bundle& solved, const Lens& lens,
                                                   std::size_t view) {
  ViewProblem buffer;
  const auto& points = solved.corrected(view, buffer).correspondences;
  const auto residuals = residuals_px(points, lens, solved.camera_from_target[view]);
  std::map<Coordinates, Vector2d> by_point;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Vector3d& x = solved.views[view].correspondences[i].point;
    by_point[{x.x(), x.y(), x.z()}] = residuals[i];
  }
  return by_point;
}

}  // namespace

std::vector<std::size_t> pose_numbers(const Bundle& bundle) {
  std::vector<std::size_t> number, first_views;
  if (bundle.views.empty()) return number;
  const SamePose same(bundle);
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto first =
        std::ranges::find_if(first_views, [&](std::size_t earlier) { return same(v, earlier); });
    number.push_back(static_cast<std::size_t>(first - first_views.begin()));
    if (first == first_views.end()) first_views.push_back(v);
  }
  return number;
}

std::size_t num_poses(std::span<const std::size_t> pose_of_view) {
  return pose_of_view.empty() ? 0 : 1 + std::ranges::max(pose_of_view);
}

double design_effect(const Bundle& solved, std::span<const std::size_t> pose_of_view) {
  constexpr std::size_t kEnoughViews = 16;  // a limit of work
  std::vector<std::vector<std::size_t>> views_of(num_poses(pose_of_view));
  for (std::size_t v = 0; v < pose_of_view.size(); ++v) views_of[pose_of_view[v]].push_back(v);
  const Lens lens = solved.lens();
  double product = 0, square = 0, views_per_pose = 0;
  std::size_t tested = 0;
  for (const std::vector<std::size_t>& views : views_of) {
    const auto count = static_cast<double>(views.size());
    views_per_pose += count * count / static_cast<double>(pose_of_view.size());
    if (views.size() < 2 || tested >= kEnoughViews) continue;
    tested += 2;
    const auto a = residuals_by_point(solved, lens, views.front());
    for (const auto& [point, residual] : residuals_by_point(solved, lens, views.back())) {
      const auto other = a.find(point);
      if (other == a.end()) continue;
      product += residual.dot(other->second);
      square += (residual.squaredNorm() + other->second.squaredNorm()) / 2;
    }
  }
  return square > 0 ? 1 + (views_per_pose - 1) * std::max(0.0, product / square) : 1;
}

}  // namespace tagcal::internal
