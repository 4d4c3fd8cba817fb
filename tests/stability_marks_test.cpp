// Cells of the maps in which ours was wrong and silent once, and what it says there now.

#include <gtest/gtest.h>

#include <algorithm>

#include "tagcal/study/stability.hpp"

namespace tagcal {
namespace {

// Ours alone in some of the cells of a map.
std::vector<StabilityTally> ours(const std::string& name, const std::vector<double>& x,
                                 const std::vector<double>& y, int trials) {
  std::vector<StabilityMap> maps = stability_maps();
  const auto map =
      std::find_if(maps.begin(), maps.end(), [&](const StabilityMap& m) { return m.name == name; });
  map->axes[0].values = x;
  map->axes[1].values = y;
  map->methods.resize(1);
  StabilityOptions options;
  options.trials = trials;
  return run_map(*map, options).tallies;
}

int silent(const StabilityTally& tally) { return tally.of(StabilityOutcome::wrong_and_silent); }

// Where a tag has two minima, the covariance of each counted with one only: 3 % before.
TEST(Marks, ATagThatMayFaceTheCameraSaysSo) {
  for (const StabilityTally& t : ours("tag-tilt-distance", {0, 5}, {2, 4}, 600))
    EXPECT_LE(silent(t), 1) << t.cell;
}

// Two poses 9 sigma^2 apart were told from each other: one flip in 700 before.
TEST(Marks, FlipsAreSeen) {
  const auto tallies = ours("tag-tilt-distance", {30}, {1.5}, 3000);
  EXPECT_LE(silent(tallies[0]), 1);
  EXPECT_GT(tallies[0].flips, 100);
}

// Each corner of all tags is the board in another place: it was the answer, always.
TEST(Marks, TagsThatAreAllTurnedOrMirroredAreNoBoard) {
  for (const StabilityTally& t : ours("swapped", {5, 6}, {3}, 4))
    EXPECT_EQ(t.said.at("no_consensus"), 4) << t.cell;
}

// Mirrored points lie near to a pose in front, and of 40 some agreed with it: always before.
TEST(Marks, PointsBehindTheCameraAreSeldomInFront) {
  const auto tallies = ours("behind-camera", {1}, {40}, 12);
  EXPECT_LE(silent(tallies[0]), 3);
}

// A turn about the line that is not known was answered with a linear covariance: 4 % before.
TEST(Marks, PointsNearlyOnALineAreDegenerate) {
  const auto tallies = ours("line", {1e-3}, {50}, 300);
  EXPECT_EQ(silent(tallies[0]), 0);
  EXPECT_GT(tallies[0].said.at("degenerate"), 250);
}

// The homography of a poor quadrangle leads to one of its minima only: five of these before.
TEST(Marks, FewPointsInAPlaneHaveMoreThanTwoPoses) {
  // Three and four points, so that the cell has its number in the map, and its seeds.
  const auto tallies = ours("points", {3, 4}, {0, 1}, 120);
  EXPECT_EQ(tallies[0].said.at("degenerate"), 120);
  EXPECT_LE(silent(tallies[2]), 3);
}

}  // namespace
}  // namespace tagcal
