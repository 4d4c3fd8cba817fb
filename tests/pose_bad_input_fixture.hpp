#pragma once

// Worlds for estimates of poses, and the conditions on every estimate for any input.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {

using Eigen::Vector2d;
using Eigen::Vector3d;

inline constexpr int kTrials = 25000;  // 1e5 cases in all

inline const ImageSize kSize{1280, 800};

// A target, its pose and its observations.
struct World {
  Lens lens = centred_pinhole(900);
  std::vector<Vector3d> points;
  Pose truth;
  std::vector<Correspondence> seen;

  void observe(double sigma_px, Random& random) {
    seen = seen_by(lens, points, truth, sigma_px, random);
  }
};

// A view with a tilt that determines its sign and the focal length.
inline World draw_world(Random& random) {
  World w;
  switch (random.index(4)) {
    case 0:
      w.points = tag_points(0.5);
      break;
    case 1:
      w.points = tag_points(0.4);
      break;
    case 2:
      w.points = points_in_box(6 + static_cast<int>(random.index(8)), 0.25, 0, random);
      break;
    case 3:
      w.points = points_in_box(6 + static_cast<int>(random.index(8)), 0.25, 1, random);
      break;
  }
  w.truth = looking_at_board(Vector3d::Zero(), random.uniform(0.6, 1.0), 1.0, random);
  return w;
}

// The members that both kinds of estimate have.
struct Answer {
  Status status;
  std::vector<PoseHypothesis> hypotheses;
  std::vector<std::size_t> outliers;
  double sigma_px, focal_px;
  std::vector<std::string> warnings;
};

inline Answer with_camera(const World& w, const PoseOptions& options = {}) {
  const PoseEstimate e = estimate_pose(w.seen, {w.lens, kSize}, options);
  return {e.status, e.hypotheses, e.outliers, e.sigma_px, 0, sentences(e.findings)};
}

inline Answer with_focal(const World& w, const PoseAndFocalOptions& options = {}) {
  const PoseAndFocalEstimate e = estimate_pose_and_focal(w.seen, kSize, options);
  EXPECT_TRUE(std::isfinite(e.sigma_focal_px) && e.covariance.allFinite());
  for (const WeakPerspectivePose& weak : e.weak_perspective) {
    EXPECT_TRUE(weak.camera_from_target.matrix().allFinite());
    EXPECT_TRUE(weak.scale_px_per_m > 0 && std::isfinite(weak.scale_px_per_m));
    EXPECT_TRUE(std::isfinite(weak.rms_px));
  }
  return {e.status, e.hypotheses, e.outliers, e.sigma_px, e.focal_px, sentences(e.findings)};
}

inline bool same_inliers_in_front(const Answer& answer, const World& w) {
  return std::all_of(
      answer.hypotheses.begin(), answer.hypotheses.end(), [&](const PoseHypothesis& h) {
        for (std::size_t i = 0; i < w.seen.size(); ++i)
          if (!std::binary_search(answer.outliers.begin(), answer.outliers.end(), i) &&
              !in_domain(w.lens, h.camera_from_target * w.seen[i].point))
            return false;
        return true;
      });
}

// The RMS residual of the inliers, by the definition.
inline double rms_px(const PoseHypothesis& h, const Answer& answer, const World& w) {
  const Lens lens = h.focal_px > 0 ? centred_pinhole(h.focal_px) : w.lens;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < w.seen.size(); ++i) {
    if (std::binary_search(answer.outliers.begin(), answer.outliers.end(), i)) continue;
    sum += (*project(lens, h.camera_from_target * w.seen[i].point) - w.seen[i].pixel).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

// Checks the conditions on every estimate for any input.
inline void expect_sound(const Answer& answer, const World& w) {
  ASSERT_TRUE(!is_answer(answer.status) || !answer.hypotheses.empty());
  ASSERT_TRUE(is_answer(answer.status) || !answer.warnings.empty() ||
              answer.status == Status::not_converged);
  ASSERT_TRUE(std::isfinite(answer.sigma_px) && std::isfinite(answer.focal_px));
  ASSERT_TRUE(std::is_sorted(answer.outliers.begin(), answer.outliers.end()));
  ASSERT_TRUE(answer.outliers.empty() || answer.outliers.back() < w.seen.size());
  double sum = 0;
  for (const PoseHypothesis& h : answer.hypotheses) {
    ASSERT_TRUE(h.camera_from_target.matrix().allFinite());
    ASSERT_NEAR(h.camera_from_target.rotation_matrix().determinant(), 1, 1e-12);
    ASSERT_TRUE(h.covariance.allFinite() && h.covariance.diagonal().minCoeff() >= 0);
    ASSERT_TRUE(std::isfinite(h.rms_px) && std::isfinite(h.focal_px));
    sum += h.probability;
  }
  ASSERT_TRUE(answer.hypotheses.empty() || std::abs(sum - 1) < 1e-9);
  ASSERT_TRUE(same_inliers_in_front(answer, w));
}

// Rotation, and the distance at the target's centre over the camera's distance from it.
inline double error_of(const Pose& pose, const World& w) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : w.points)
    centre += (p - w.points[0]) / static_cast<double>(w.points.size());
  centre += w.points[0];
  return angle_between_rad(pose, w.truth) +
         (pose * centre - w.truth * centre).norm() / (w.truth * centre).norm();
}

inline double least_error(const Answer& answer, const World& w) {
  double least = kInfinity;
  for (const PoseHypothesis& h : answer.hypotheses)
    least = std::min(least, error_of(h.camera_from_target, w));
  return least;
}

}  // namespace tagcal
