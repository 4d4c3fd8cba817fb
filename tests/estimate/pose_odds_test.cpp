// The odds of the two poses of a plane, by calibration: of the views whose likelier pose is given
// 0.7 to 0.8, that share is right, whatever the tilt, the distance and the noise.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
using namespace study;
namespace {

// Views by what was said of their likelier pose.
struct Odds {
  double said = 0, variance = 0;  // sums of p and of p (1 - p)
  int right = 0, count = 0;

  // How far the share that is right is from what was said, in standard deviations.
  double in_sigmas() const { return (right - said) / std::sqrt(variance); }
};

// Adds a view of a square with a side of 0.1 m if two poses fit and the likelier one is given 0.7
// to 0.8.
void add_view(const ViewRange& range, Random& random, Odds& odds) {
  const PoseTask task = draw_task(square_points(0.1), range, random);
  const PoseEstimate e = estimate_pose(task.correspondences, task.camera, {range.sigma_px});
  if (e.hypotheses.size() != 2) return;
  const double p = e.hypotheses[0].probability;
  if (p < 0.7 || p > 0.8) return;
  const auto error_of = [&](const PoseHypothesis& h) {
    return angle_between_rad(h.camera_from_target, task.camera_from_target);
  };
  odds.said += p;
  odds.variance += p * (1 - p);
  odds.right += error_of(e.hypotheses[0]) < error_of(e.hypotheses[1]);
  ++odds.count;
}

// Below some 15 degrees of tilt both minima lie beside the truth: neither pose is the right one.
TEST(PoseOdds, AreRightAsOftenAsTheySay) {
  const std::vector<ViewRange> ranges = {{15, 30, 1.5, 2.5, 0.3}, {15, 30, 3, 5, 0.1},
                                         {30, 50, 3, 5, 0.1},     {30, 50, 3, 5, 0.3},
                                         {50, 65, 3, 5, 0.1},     {20, 60, 1, 1.5, 1}};
  Random random(3);
  for (const ViewRange& range : ranges) {
    Odds odds;
    for (int trial = 0; trial < 6000; ++trial) add_view(range, random, odds);
    EXPECT_GT(odds.count, 200);
    EXPECT_LT(std::abs(odds.in_sigmas()), 3.5)
        << range.min_tilt_deg << " degrees, " << range.min_distance_m << " m, " << range.sigma_px
        << " px: " << odds.right << " of " << odds.count << " are right, " << odds.said
        << " were said";
  }
}

// From all sides alike up to 60 degrees: the views that face the camera are as rare as they are.
TEST(PoseOdds, AreRightFromAllSides) {
  Random random(4);
  Odds odds;
  for (int trial = 0; trial < 6000; ++trial) {
    const double tilt_deg = std::acos(random.uniform(0.5, 1)) / kDegree;
    add_view({tilt_deg, tilt_deg, 1.5, 2.5, 0.3}, random, odds);
  }
  EXPECT_GT(odds.count, 200);
  EXPECT_LT(std::abs(odds.in_sigmas()), 3.5) << odds.right << " of " << odds.count;
}

}  // namespace
}  // namespace tagcal
