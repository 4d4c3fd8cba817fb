// What other libraries print in a study does not reach the terminal.

#include <gtest/gtest.h>

#include <cstdio>

#include "study/peers/pose_peers.hpp"
#include "study/peers/quiet_stderr.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

// Everything that reaches descriptor 2 while the method solves noisy and wrong views.
std::string printed_by(const PoseMethod& method, double sigma_px, double wrong) {
  Random random(5);
  testing::internal::CaptureStderr();
  for (int i = 0; i < 300; ++i)
    method
        .prepare(draw_task(square_points(0.05),
                           {.max_tilt_deg = 75, .sigma_px = sigma_px, .wrong = wrong}, random))
        .solve();
  std::fflush(nullptr);
  return testing::internal::GetCapturedStderr();
}

// Without QuietStderr: "fix_pose_ambiguities(): Error, more than one new minimum found".
TEST(QuietPeers, AprilTagsPoseOfNoisyTags) { EXPECT_EQ(printed_by(apriltag_pose(), 3, 0), ""); }

// Without QuietStderr: "Residual and Jacobian evaluation failed", of points behind the camera.
TEST(QuietPeers, CeresFromWrongCorners) {
  EXPECT_EQ(printed_by(ceres_autodiff_pose(), 1, 0.5), "");
}

TEST(QuietPeers, TheStreamIsBackAfterTheLastOne) {
  FILE* const usual = stderr;
  {
    const QuietStderr first;
    { const QuietStderr second; }
    EXPECT_NE(stderr, usual);
  }
  EXPECT_EQ(stderr, usual);
}

}  // namespace
}  // namespace tagcal::study
