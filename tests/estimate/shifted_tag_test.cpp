#include "tagcal/estimate/pose/shifted_tag_test.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr double kShiftedSigma = 0.5;
const Lens kTagLens = centred_pinhole(900);

struct TagsInView {
  std::vector<Correspondence> seen;
  std::vector<int> groups;
  Pose pose;
};

// The first tags of the board, with noise.
TagsInView some_tags(std::size_t count, double sigma, Random& random) {
  TagsInView view;
  view.pose =
      looking_at_board({0, 0, 0}, random.uniform(0.2, 0.8), random.uniform(0.8, 1.2), random);
  auto points = board_points();
  points.resize(4 * count);
  view.seen = seen_by(kTagLens, points, view.pose, sigma, random);
  for (std::size_t i = 0; i < points.size(); ++i) view.groups.push_back(static_cast<int>(i / 4));
  return view;
}

void shift(TagsInView& view, int tag, const Vector2d& by_px) {
  for (std::size_t i = 0; i < view.seen.size(); ++i)
    if (view.groups[i] == tag) view.seen[i].pixel += by_px;
}

std::optional<int> shifted_in(const TagsInView& view) {
  const PoseOptions options;
  const PoseProblem problem(view.seen, options);
  const auto fit = pose_minima<6>(problem, kTagLens, options);
  return fit ? shifted_tag<6>(problem, view.groups, kTagLens, fit->best().state) : std::nullopt;
}

// Fuzzing found a search whose last round left no inlier, which then used all points.
TEST(PoseProblem, OfNoChosenPointHasNone) {
  Random random(1);
  const TagsInView view = some_tags(3, kShiftedSigma, random);
  const PoseOptions options;
  const std::vector<std::size_t> none, two = {1, 4};
  EXPECT_EQ(PoseProblem(view.seen, options).size(), view.seen.size());
  EXPECT_EQ(PoseProblem(view.seen, options, two).size(), 2u);
  const PoseProblem problem(view.seen, options, none);
  EXPECT_EQ(problem.size(), 0u);
  EXPECT_NE(defect(problem), "");
}

TEST(ShiftedTag, NoneInPureNoise) {
  Random random(1);
  int shifted = 0;
  constexpr int kTrials = 2000;
  for (int i = 0; i < kTrials; ++i)
    shifted += shifted_in(some_tags(3 + random.index(10), kShiftedSigma, random)).has_value();
  EXPECT_LE(shifted, 12);  // of about 15,000 tags 4 are expected
}

TEST(ShiftedTag, FindsATagThatIsSomePixelsOff) {
  Random random(2);
  int found = 0;
  constexpr int kTrials = 500;
  for (int i = 0; i < kTrials; ++i) {
    TagsInView view = some_tags(6, kShiftedSigma, random);
    const int tag = static_cast<int>(random.index(6));
    const double angle = random.uniform(0, 6.28);
    shift(view, tag, 8 * kShiftedSigma * Vector2d(std::cos(angle), std::sin(angle)));
    found += shifted_in(view) == tag;
  }
  EXPECT_GE(found, kTrials * 97 / 100);
}

TEST(ShiftedTag, NoneOfTwoTagsNorInExactData) {
  Random random(3);
  TagsInView two = some_tags(2, kShiftedSigma, random);
  shift(two, 1, {3, 0});
  EXPECT_FALSE(shifted_in(two));
  EXPECT_FALSE(shifted_in(some_tags(6, 0, random)));
}

// A slightly shifted tag, whose single corners are no outliers, does not pull the pose of a few
// correct tags.
TEST(ShiftedTag, DoesNotPullThePose) {
  Random random(4);
  int pulled = 0, answers = 0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    TagsInView view = some_tags(36, kShiftedSigma, random);
    for (int tag = 0; tag < 36; ++tag)
      if (tag % 5 != 0)
        for (std::size_t k = 0; k < 4; ++k)
          view.seen[static_cast<std::size_t>(4 * tag) + k].pixel +=
              Vector2d(150 * (tag % 7) - 500, 70 * (tag % 11) - 400);
    shift(view, 35, {0, 3});
    PoseOptions options;
    options.groups = view.groups;
    const PoseEstimate estimate = estimate_pose(view.seen, Camera{kTagLens, {1280, 800}}, options);
    if (!is_answer(estimate.status)) continue;
    ++answers;
    pulled += normalised_squared_error(estimate.hypotheses.front(), view.pose) > 40;
  }
  EXPECT_GE(answers, kTrials * 98 / 100);
  EXPECT_LE(pulled, kTrials * 4 / 100);  // more than half without the test
}

// Under a wrong lens most tags stay inliers, and a finding says so.
TEST(ShiftedTag, AWrongLensRejectsFewTags) {
  Random random(5);
  const Lens bent = Perspective({900, 900, 639.5, 399.5, -0.1, 0.03, 0, 0, 0});
  for (int i = 0; i < 20; ++i) {
    const Pose pose = looking_at_board({0, 0, 0}, random.uniform(0.2, 0.8), 0.9, random);
    TagsInView view{seen_by(bent, board_points(), pose, 0.1, random), {}, pose};
    for (std::size_t k = 0; k < view.seen.size(); ++k)
      view.groups.push_back(static_cast<int>(k / 4));
    shift(view, 7, {300, 40});
    PoseOptions options;
    options.groups = view.groups;
    const PoseEstimate estimate = estimate_pose(view.seen, Camera{kTagLens, {1280, 800}}, options);
    ASSERT_TRUE(is_answer(estimate.status)) << i;
    EXPECT_LE(estimate.outliers.size(), 28u) << i;
    EXPECT_FALSE(estimate.findings.empty()) << i;
  }
}

TEST(ShiftedTag, ScoresOfVarianceRatiosAreThoseOfTables) {
  // Quantiles of F to 1e-3 of each tail: 3.09 standard deviations.
  EXPECT_NEAR(variance_ratio_score(5.44, 8, 20), 3.09, 0.03);
  EXPECT_NEAR(variance_ratio_score(9.63, 4, 12), 3.09, 0.03);
  EXPECT_NEAR(variance_ratio_score(3.266, 8, 1e6), 3.09, 0.03);  // chi-square
  EXPECT_NEAR(variance_ratio_score(1, 50, 50), 0, 0.01);
}

}  // namespace
}  // namespace tagcal
