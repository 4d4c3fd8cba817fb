// Target files of checkerboards, circle grids and ChArUco boards.
#include <gtest/gtest.h>

#include "target_file_fixture.hpp"

namespace tagcal {
namespace {

TEST_F(TargetFile, CheckerboardsHaveKalibrsKeys) {
  const Board board = read(kChecker);
  EXPECT_TRUE(tags_of(board).empty());
  const std::vector<TargetPoint> points = target_points(board);
  ASSERT_EQ(points.size(), 42U);
  EXPECT_TRUE(points[8].position.isApprox(Eigen::Vector3d(0.05, 0.06, 0)));
  EXPECT_TRUE(read_kind<Checkerboard>(kChecker).starts_black);
  const auto other =
      read_kind<Checkerboard>(kChecker + "starts_black: false\nfirst_id: 5\nauthor: me\n");
  EXPECT_FALSE(other.starts_black);
  EXPECT_EQ(other.first_id, 5);
  EXPECT_EQ(warnings_.size(), 1U);
  EXPECT_EQ(read_kind<Checkerboard>(kChecker + "first_id: 5\n", 9).first_id, 9);
  expect_bad(
      kChecker,
      {{"targetCols: 7", "targetCols: 1", ": targetCols: must be a whole number from 2 to 100000"},
       {"targetCols: 7", "targetCols: 50000",
        ": targetCols * targetRows: must be at most 100000, got 300000"},
       {"targetRows: 6\n", "", ": targetRows: the key is missing"},
       {"targetRows", "rows",
        ": targetRows: the key is missing; if rows is meant, write targetRows"},
       {"targetRows", "target_rows",
        ": targetRows: the key is missing; if target_rows is meant, write targetRows"},
       {"Meters: 0.06", "Meters: 0", ": rowSpacingMeters: must be > 0, got 0"},
       {"Meters: 0.05", "Meters: x",
        ": colSpacingMeters: must be a length in metres, or with its unit (30mm, 3cm, 0.03m, 1in), "
        "got x"},
       {"targetCols", "starts_black: 1\ntargetCols", ": starts_black: must be true or false, got"},
       {"targetCols", "first_id: 2147483640\ntargetCols",
        ": first_id: the ids must stay below 2^31, but end at 2147483681"}});
}

TEST_F(TargetFile, GridsOfCirclesHaveKalibrsKeys) {
  EXPECT_EQ(target_points(read(kCircles)).size(), 44U);
  auto grid = read_kind<CircleGrid>(kCircles);
  EXPECT_TRUE(grid.asymmetric);
  EXPECT_EQ(grid.diameter, 0.4 * 0.02);
  grid = read_kind<CircleGrid>(kCircles + "diameterMeters: 0.025\nfirst_id: 5\nauthor: me\n");
  EXPECT_EQ(grid.diameter, 0.025);
  EXPECT_EQ(grid.first_id, 5);
  EXPECT_EQ(warnings_.size(), 1U);
  EXPECT_EQ(read_kind<CircleGrid>(kCircles, 9).first_id, 9);
  const std::string symmetric = kCircles.substr(0, kCircles.find("asymm"));
  EXPECT_FALSE(read_kind<CircleGrid>(symmetric).asymmetric);
  const fs::path file = folder_ / "written.yaml";
  write_target(file, make_board(grid));
  const auto again = std::get<CircleGrid>(read_target(file).pattern);
  EXPECT_EQ(std::tuple(again.columns, again.rows, again.spacing, again.diameter, again.asymmetric,
                       again.first_id),
            std::tuple(4, 11, 0.02, 0.025, true, 5));
  expect_bad(
      kCircles,
      {{"targetCols: 4", "targetCols: 1", ": targetCols: must be a whole number from 2 to 100000"},
       {"targetRows: 11\n", "", ": targetRows: the key is missing"},
       {"Meters: 0.02", "Meters: 0", ": spacingMeters: must be > 0, got 0"},
       {"Grid: True", "Grid: 1", ": asymmetricGrid: must be true or false, got 1"},
       {"targetCols", "diameterMeters: 0.03\ntargetCols",
        ": diameterMeters: must be less than 0.0282843, the distance of centres, got 0.03"},
       {"targetCols", "diameterMeters: 0\ntargetCols", ": diameterMeters: must be > 0, got 0"}});
}

TEST_F(TargetFile, CharucoBoardsCountSquares) {
  Board board = read(kCharuco);
  EXPECT_EQ(read_kind<Charuco>(kCharuco).dictionary, "DICT_5X5_100");
  EXPECT_EQ(target_points(board).size(), 12U);
  EXPECT_EQ(tags_of(board).size(), 10U);
  EXPECT_FALSE(checkers(board)->starts_black);
  board = read(kCharuco + "legacy: true\nfirst_id: 100\nfirst_marker_id: 30\n");
  EXPECT_TRUE(checkers(board)->starts_black);
  EXPECT_EQ(target_points(board)[0].id.tag_id, 100);
  EXPECT_EQ(tags_of(board)[0].id, 30);
  EXPECT_EQ(tags_of(read(kCharuco, 7))[0].id, 0);
  expect_bad(
      kCharuco,
      {{"squareCols: 5", "squareCols: 2", ": squareCols: must be a whole number from 3 to 100000"},
       {"squareSize: 0.04", "squareSize: 0", ": squareSize: must be > 0, got 0"},
       {"markerSize: 0.03", "markerSize: 0.04",
        ": markerSize: must be less than squareSize 0.04, got 0.04"},
       {"dictionary: DICT_5X5_100\n", "", ": dictionary: the key is missing"},
       {"dictionary", "legacy: yes please\ndictionary", ": legacy: must be true or false, got"},
       {"dictionary", "dictionry", ": dictionry: unknown key; did you mean dictionary?"},
       {"dictionary", "first_marker_id: 2147483640\ndictionary",
        ": first_marker_id: the ids must stay below 2^31"}});
}

}  // namespace
}  // namespace tagcal
