#include <apriltag/common/image_u8.h>
#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include <algorithm>
#include <functional>

#include "apriltag_families.hpp"
#include "expect.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

// Kalibr's example: aprilgrid 6x6, tagSize 0.088, tagSpacing 0.3.
const AprilGrid kKalibr{6, 6, 0.088, 0.3, 0};

TEST(GridBoard, CornersAreKalibrs) {
  const Board board = make_board(kKalibr);
  ASSERT_EQ(tags_of(board).size(), 36u);
  const auto points = target_points(board);
  ASSERT_EQ(points.size(), 144u);
  // GridCalibrationTargetAprilgrid::createGridPoints: point (r, c) of the 12x12 grid of corners is
  // at (int)(c / 2) * (1 + spacing) * size + (c % 2) * size.
  const double pitch = 0.088 * 1.3;
  for (const TargetPoint& point : points) {
    const int tag_row = point.id.tag_id / 6;
    const int tag_column = point.id.tag_id % 6;
    const bool right = point.id.corner == 1 || point.id.corner == 2;
    const bool upper = point.id.corner >= 2;
    const Vector3d expected(tag_column * pitch + (right ? 0.088 : 0),
                            tag_row * pitch + (upper ? 0.088 : 0), 0);
    EXPECT_LT((point.position - expected).norm(), 1e-15);
  }
  EXPECT_LT(points.front().position.norm(), 1e-16);
  EXPECT_TRUE(std::ranges::is_sorted(points, {}, &TargetPoint::id));
}

TEST(Boards, RefuseMorePartsAndIdsThanFit) {
  EXPECT_ERROR(make_board(AprilGrid{100'000, 100'000, 0.1, 0.3, 0}),
               "board: columns * rows: must be at most 100000, got 10000000000");
  EXPECT_ERROR(make_board(AprilGrid{2, 2, 0.1, 0.3, 2'147'483'645}),
               "board: first_id: the ids must stay below 2^31, but end at 2147483648");
  EXPECT_ERROR(make_board(Checkerboard{1000, 101, 0.1, 0.1}),
               "board: columns * rows: must be at most 100000, got 101000");
  EXPECT_ERROR(make_board(Charuco{4, 4, 0.1, 0.05, "DICT_4X4_50", false, 0, 2'147'483'647}),
               "board: first_marker_id: the ids must stay below 2^31, but end at 2147483654");
  EXPECT_EQ(target_points(make_board(Checkerboard{1000, 100, 0.1, 0.1})).size(), 100'000u);
}

TEST(GridBoard, NumbersTagsFromFirstId) {
  const Board board = make_board(AprilGrid{3, 2, 0.1, 0.25, 40, "tag25h9", 1, false});
  const std::vector<Tag> tags = tags_of(board);
  ASSERT_EQ(tags.size(), 6u);
  EXPECT_EQ(tags.front().id, 40);
  EXPECT_EQ(tags.back().id, 45);
  EXPECT_LT((tags[4].board_from_tag.translation() - Vector3d(0.175, 0.175, 0)).norm(), 1e-15);
  EXPECT_EQ(tag_kind(board)->family, "tag25h9");
  EXPECT_EQ(tag_kind(board)->border_bits, 1);
}

TEST(GridBoard, RejectsWhatIsNoBoard) {
  EXPECT_THROW(make_board(AprilGrid{0, 6, 0.088, 0.3, 0}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, -1, 0.088, 0.3, 0}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, 6, 0, 0.3, 0}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, 6, std::nan(""), 0.3, 0}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, 6, 0.088, -0.1, 0}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, 6, 0.088, 0.3, -1}), Error);
  EXPECT_THROW(make_board(AprilGrid{6, 6, 0.088, 0.3, 0, "tag36h11", 0}), Error);
  EXPECT_THROW(make_board(kKalibr, {.flatness = 0.2}), Error);
}

TEST(Dataset, PointsInWorldAreThoseOfAllBoards) {
  const Pose there(exp_rotation({0, 0, std::numbers::pi / 2}), {1, 2, 3});
  const Board points = make_board(Points{{{{7, 0}, {1, 0, 0}}, {{3, 0}, {0, 1, 0}}}});
  const Board grid = make_board(AprilGrid{2, 1, 0.1, 0.5, 10});
  const auto all = points_in_world({{points, there}, {grid, Pose()}});
  ASSERT_EQ(all.size(), 2u + 8u);
  EXPECT_LT((all.at({7, 0}) - Vector3d(1, 3, 3)).norm(), 1e-15);
  EXPECT_LT((all.at({11, 2}) - Vector3d(0.25, 0.1, 0)).norm(), 1e-15);
}

TEST(Checkerboard, CornersAreRowByRowFromBelow) {
  const Board board = make_board(Checkerboard{
      .columns = 3, .rows = 2, .column_spacing = 0.02, .row_spacing = 0.03, .first_id = 7});
  const std::vector<TargetPoint> points = target_points(board);
  ASSERT_EQ(points.size(), 6u);
  EXPECT_EQ(points[4].id, (CornerId{11, 0}));
  EXPECT_TRUE(points[4].position.isApprox(Vector3d(0.02, 0.03, 0)));
  EXPECT_THROW(make_board(Checkerboard{.columns = 1, .rows = 2}), Error);
}

TEST(CircleGrid, CentresAreOpenCvsFromBelow) {
  CircleGrid grid{4, 11, 0.02, 0.012, true, 7};
  const std::vector<TargetPoint> centres = target_points(make_board(grid));
  ASSERT_EQ(centres.size(), 44u);
  for (int i = 0; i < 11; ++i)  // row i of OpenCV's, whose y points down
    for (int j = 0; j < 4; ++j) {
      const TargetPoint& centre = centres[static_cast<std::size_t>(4 * (10 - i) + j)];
      EXPECT_EQ(centre.id, (CornerId{7 + 4 * (10 - i) + j, 0}));
      EXPECT_LT((centre.position - Vector3d((2 * j + i % 2) * 0.02, (10 - i) * 0.02, 0)).norm(),
                1e-15);
    }
  grid.asymmetric = false;
  EXPECT_LT((target_points(make_board(grid))[5].position - Vector3d(0.02, 0.02, 0)).norm(), 1e-15);
  grid.diameter = 0.02;
  EXPECT_THROW(make_board(grid), Error);
  grid.asymmetric = true;
  EXPECT_NO_THROW(make_board(grid));
  grid.rows = 1;
  EXPECT_THROW(make_board(grid), Error);
}

// Layout by OpenCV: squares from the upper left, the first one black; before 4.6 white if the
// number of rows is even.
TEST(Charuco, MarkersStandInWhiteSquares) {
  Board board = make_board(Charuco{3, 4, 0.04, 0.03, "DICT_4X4_50"});
  ASSERT_EQ(tags_of(board).size(), 6u);
  EXPECT_FALSE(checkers(board)->starts_black);
  EXPECT_TRUE(tags_of(board)[0].board_from_tag.translation().isApprox(Vector3d(0.02, 0.1, 0)));
  board = make_board(Charuco{3, 4, 0.04, 0.03, "DICT_4X4_50", true});
  EXPECT_TRUE(checkers(board)->starts_black);
  EXPECT_TRUE(tags_of(board)[0].board_from_tag.translation().isApprox(Vector3d(-0.02, 0.1, 0)));
  EXPECT_EQ(target_points(board).size(), 6u);
  EXPECT_THROW(make_board(Charuco{3, 4, 0.04, 0.05}), Error);
}

TEST(Boards, SayWhatTheirPointsAndTagsAre) {
  struct Row {
    BoardPattern pattern;
    PointKind points;
    const char* family;  // none: no tags
    bool has_squares;
  };
  const Row rows[] = {
      {Points{{{{7, 0}, {1, 0, 0}}}}, PointKind::measured, "none", false},
      {Tags{.tags = {{4, 0.1}}}, PointKind::tag_corner, "tag36h11", false},
      {kKalibr, PointKind::tag_corner, "tag36h11", false},
      {Checkerboard{3, 2, 1, 1}, PointKind::checker_corner, "none", true},
      {Charuco{4, 3, 1, 0.5, "DICT_4X4_50"}, PointKind::checker_corner, "DICT_4X4_50", true}};
  for (const Row& row : rows) {
    const Board board = make_board(row.pattern);
    EXPECT_EQ(point_kind(board), row.points) << row.family;
    EXPECT_EQ(tag_kind(board).value_or(TagKind{"none"}).family, row.family);
    EXPECT_EQ(tags_of(board).empty(), row.family == std::string("none"));
    EXPECT_EQ(checkers(board).has_value(), row.has_squares) << row.family;
  }
  EXPECT_TRUE(target_points(Board()).empty());
}

}  // namespace
}  // namespace tagcal
