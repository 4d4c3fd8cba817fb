#include <gtest/gtest.h>

#include <Eigen/LU>

#include "rendered_near_grid.hpp"
#include "tagcal/detect/detector.hpp"

// AprilGrids so close to a fisheye camera that they reach over more than 100 degrees of its view.

namespace tagcal {
namespace {

struct NearTally {
  int corners = 0, found = 0, wrong = 0;
  double nees = 0;
};

void add(const NearGridSpec& spec, std::uint64_t seed, NearTally& tally) {
  Random random(52, seed);
  const NearGridView view = near_grid_view(spec, random);
  DetectOptions options;
  options.threads = 1;
  tally.corners += static_cast<int>(view.corners.size());
  for (const Observation& seen :
       detect(view.image, {{view.board, Pose()}}, options, "near").view.observations) {
    const bool is_counted = view.corners.contains(seen.id);
    const auto& truth = (is_counted ? view.corners : view.others).at(seen.id);
    tally.wrong += (seen.pixel - truth).norm() > 0.5;
    if (!is_counted) continue;
    ASSERT_TRUE(seen.covariance_px2);
    const Eigen::Vector2d error = seen.pixel - truth;
    ++tally.found, tally.nees += error.dot(seen.covariance_px2->inverse() * error) / 2;
  }
}

class NearGrid : public testing::TestWithParam<int> {};

TEST_P(NearGrid, IsFoundAndItsCornersAreWithinTheirClaims) {
  NearTally tally;
  std::uint64_t seed = 0;
  for (const char* model : {"fisheye4", "ds", "eucm"})
    for (const double field_deg : {150., 195.})
      for (const double span_deg : {125., 150.})
        add({model, field_deg, span_deg, GetParam()}, ++seed, tally);
  EXPECT_GT(tally.corners, 1000);
  EXPECT_GE(tally.found, 0.97 * tally.corners);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GT(tally.nees / tally.found, 0.85);
  EXPECT_LT(tally.nees / tally.found, 1.15);
}

INSTANTIATE_TEST_SUITE_P(Borders, NearGrid, testing::Values(1, 2));

// AprilTag reads none of these tags, the largest of which are 400 px wide.
TEST(NearGridAlone, IsFoundWhereAprilTagReadsNoTag) {
  NearTally tally;
  for (const std::uint64_t seed : {1, 2, 3}) add({"ds", 180, 162, 1}, seed, tally);
  EXPECT_GE(tally.found, 0.85 * tally.corners);
  EXPECT_EQ(tally.wrong, 0);
}

}  // namespace
}  // namespace tagcal
