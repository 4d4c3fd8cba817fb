// The maps of tags in pictures: what is held against what, and a few cells.

#include <gtest/gtest.h>

#include <cmath>

#include "study/atlas/map_picture.hpp"
#include "study/atlas/stability_judge.hpp"

namespace tagcal {
using namespace study;
namespace {

using Eigen::Vector2d;

CornerTask task_of(double side_px) {
  Random random(7);
  TagViewSpec spec;
  spec.side_px = side_px;
  return draw_corner_task(spec, random);
}

CornerAnswer moved(const CornerTask& task, const Vector2d& by) {
  CornerAnswer answer{task.view.corners, {}};
  answer.corners[2] += by;
  return answer;
}

StabilityOutcome outcome_of(const std::optional<CornerAnswer>& answer, const CornerTask& task,
                            bool ours) {
  return judge_corners(answer, task, ours).outcome;
}

TEST(PictureMaps, OneCornerOutsideOfItsEllipseIsWrong) {
  const CornerTask task = task_of(40);
  const double five = std::sqrt(five_sigma_square(2));
  CornerAnswer answer = moved(task, {0.01 * five * 0.99, 0});
  answer.covariance_px2.emplace();
  answer.covariance_px2->fill(1e-4 * Matrix2::Identity());
  EXPECT_EQ(outcome_of(answer, task, true), StabilityOutcome::right_and_said);
  EXPECT_EQ(judge_corners(answer, task, true).said, "covariance");
  answer.corners[2].x() += 0.02 * 0.01 * five;
  EXPECT_EQ(outcome_of(answer, task, true), StabilityOutcome::wrong_and_silent);
}

TEST(PictureMaps, CornersWithoutACovarianceAreTakenAsEstimatorsTakeThem) {
  const CornerTask task = task_of(40);
  const double five = std::sqrt(five_sigma_square(2));
  EXPECT_EQ(outcome_of(moved(task, {0, 0.49 * five}), task, true),
            StabilityOutcome::right_and_said);
  EXPECT_EQ(outcome_of(moved(task, {0, 0.51 * five}), task, true),
            StabilityOutcome::wrong_and_silent);
  EXPECT_EQ(outcome_of(moved(task, {0, 0.09 * five}), task, false),
            StabilityOutcome::right_and_said);
  EXPECT_EQ(outcome_of(moved(task, {0, 0.12 * five}), task, false),
            StabilityOutcome::wrong_and_silent);
}

TEST(PictureMaps, ATagThatIsNotFoundIsRefusedWhereItIsReadable) {
  EXPECT_EQ(outcome_of({}, task_of(40), true), StabilityOutcome::right_but_refused);
  EXPECT_EQ(outcome_of({}, task_of(8), true), StabilityOutcome::wrong_and_said);
  TagViewSpec spec;
  spec.tilt_deg = 80;
  EXPECT_FALSE(is_readable(spec));
  spec.tilt_deg = 0;
  EXPECT_TRUE(is_readable(spec));
  spec.blur_px = 3;
  EXPECT_FALSE(is_readable(spec));
}

TEST(PictureMaps, TheBoundIsThatOfThePictureAndGrowsWithTheNoise) {
  TagViewSpec spec;
  Random quiet(3), loud(3);
  const CornerTask two = draw_corner_task(spec, quiet);
  spec.noise_levels = 20;
  const CornerTask twenty = draw_corner_task(spec, loud);
  EXPECT_GT(two.bound_px(), 0.004);  // 0.0066 px of a tag of 40 px by itself
  EXPECT_LT(two.bound_px(), 0.012);
  EXPECT_NEAR(twenty.bound_px() / two.bound_px(), 20 / std::hypot(2.0, std::sqrt(1.0 / 12)), 0.1);
}

// Few trials of three cells: clear, too small, and blurred.
TEST(PictureMaps, OursSaysWhatIsSo) {
  StabilityMap map = tag_size_blur_map();
  map.axes[0].values = {8, 20, 60};
  map.axes[1].values = {0.8, 2};
  StabilityOptions options;
  options.trials = 6;
  options.threads = 2;
  const StabilityResult result = run_map(map, options);
  for (const StabilityTally& t : result.tallies) {
    if (!map.methods[t.method].ours) continue;
    EXPECT_EQ(t.of(StabilityOutcome::wrong_and_silent), 0) << map.cell_label(t.cell);
    const std::vector<double> at = map.values(t.cell);
    if (at[0] == 8) {
      EXPECT_EQ(t.said.at("no tag"), 6);
    } else if (at[0] == 60 || (at[0] == 20 && at[1] == 0.8)) {
      EXPECT_EQ(t.said.at("covariance"), 6) << map.cell_label(t.cell);
      // The bound knows that nothing bends the tag.
      EXPECT_LT(t.rms_over_bound, 3.2) << map.cell_label(t.cell);
    }
  }
}

}  // namespace
}  // namespace tagcal
