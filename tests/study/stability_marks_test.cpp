// Cells of the maps in which ours was wrong and silent once, and what it says there now.

#include <gtest/gtest.h>

#include <algorithm>

#include "study/atlas/stability.hpp"

namespace tagcal {
using namespace study;
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

// Ours alone in cells by their numbers, so with the trials of the map.
std::vector<StabilityTally> ours_in(const std::string& name, const std::vector<std::size_t>& cells,
                                    int trials) {
  const std::vector<StabilityMap> maps = stability_maps();
  StabilityMap map = ours_alone(*std::find_if(
      maps.begin(), maps.end(), [&](const StabilityMap& m) { return m.name == name; }));
  map.methods.resize(1);
  StabilityOptions options;
  options.trials = trials;
  options.cells = cells;
  return run_map(map, options).tallies;
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

// Mirrored points that are near to a plane agree with a pose in front, and their number grows as
// the tolerance: one in eight before. Beside ten of forty that are right they were a rival: one
// in 23.
TEST(Marks, PointsBehindTheCameraAreNotInFront) {
  const auto tallies = ours_in("behind-camera", {14, 20}, 60);
  EXPECT_EQ(tallies[0].said.at("ok"), 60);
  EXPECT_EQ(tallies[1].said.at("no_consensus"), 60);
}

// A turn about the line that is not known was answered with a linear covariance: 4 % before.
TEST(Marks, PointsNearlyOnALineAreDegenerate) {
  const auto tallies = ours("line", {1e-3}, {50}, 300);
  EXPECT_EQ(silent(tallies[0]), 0);
  EXPECT_GT(tallies[0].said.at("degenerate"), 250);
}

// The homography of a poor quadrangle leads to one of its minima only, and the likelihood of few
// points is curved and flat: 13 of these before.
TEST(Marks, FewPointsInAPlaneClaimWhatTheirLikelihoodAllows) {
  for (const StabilityTally& t : ours_in("points", {2}, 1300)) EXPECT_LE(silent(t), 1) << t.cell;
}

// Four points nearly on a line, with a turn about it that is just known: 7 and 8 before.
TEST(Marks, FourPointsNearlyOnALineClaimWhatTheirLikelihoodAllows) {
  for (const StabilityTally& t : ours_in("line", {21, 24}, 1300)) EXPECT_LE(silent(t), 1) << t.cell;
}

// Noise tilts a board that faces the camera, and at that tilt the focal length seems to be known:
// two of these were answered before, both wrong.
TEST(Marks, TheFocalLengthOfABoardThatFacesTheCameraIsRefused) {
  const auto tallies = ours_in("focal-tilt-noise", {6}, 1000);
  EXPECT_EQ(silent(tallies[0]), 0);
  EXPECT_GT(tallies[0].said.at("focal_not_observable"), 900);
}

// Of four tags two with each other's ids: half of the corners agree on the board turned by half a
// turn, as many as are right: one in ten before.
TEST(Marks, HalfABoardThatAgreesOnHalfATurnIsNoConsensus) {
  const auto tallies = ours_in("swapped", {9}, 300);
  EXPECT_LE(silent(tallies[0]), 1);
  EXPECT_GT(tallies[0].said.at("ok"), 250);
}

TEST(OursAlone, HaveTheTrialsThatTheyHaveAmongPeers) {
  StabilityMap map = stability_maps().front();
  std::reverse(map.methods.begin(), map.methods.end());  // so that ours is not the first by chance
  map.draw = [draw = map.draw, n = map.methods.size()](std::span<const double> at, Random& random) {
    return [problem = draw(at, random), n](std::size_t m) { return problem(n - 1 - m); };
  };
  StabilityOptions options;
  options.trials = 4;
  options.cells = {3, 17};
  const auto among = run_map(map, options).tallies;
  const auto alone = run_map(ours_alone(map), options).tallies;
  ASSERT_EQ(alone.size(), 2u);
  ASSERT_EQ(among.size(), 2 * map.methods.size());
  for (std::size_t i = 0; i < 2; ++i) {
    const StabilityTally& same = among[(i + 1) * map.methods.size() - 1];
    EXPECT_EQ(alone[i].cell, options.cells[i]);
    EXPECT_EQ(alone[i].said, same.said);
    EXPECT_EQ(alone[i].rms_over_bound, same.rms_over_bound);
  }
}

}  // namespace
}  // namespace tagcal
