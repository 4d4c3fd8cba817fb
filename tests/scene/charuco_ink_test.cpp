#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "markers_of_opencv.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr int kStep = 10;  // pixels from sample to sample; a cell of a marker has 2 x 2 samples

struct Layout {
  int columns;  // of squares
  int rows;
  int marker_cells;  // of 20 pixels; a square has three more
  int dictionary;
  const char* name;
};

constexpr std::array kLayouts = {
    Layout{5, 4, 6, cv::aruco::DICT_4X4_50, "DICT_4X4_50"},
    Layout{4, 5, 7, cv::aruco::DICT_5X5_100, "DICT_5X5_100"},
    Layout{3, 6, 8, cv::aruco::DICT_6X6_250, "DICT_6X6_250"},
    Layout{6, 3, 7, cv::aruco::DICT_ARUCO_ORIGINAL, "DICT_ARUCO_ORIGINAL"}};

// In units of a marker's cell.
Board board_of(const Layout& layout, bool legacy) {
  const double square = layout.marker_cells + 3;
  return make_board(Charuco{layout.columns, layout.rows, square,
                            static_cast<double>(layout.marker_cells), layout.name, legacy});
}

bool black(const std::vector<InkCell>& ink, const Vector2d& p) {
  return std::ranges::any_of(ink, [&](const InkCell& r) {
    return p.x() > r[0].x() && p.x() < r[2].x() && p.y() > r[0].y() && p.y() < r[2].y();
  });
}

// The point of the board that is drawn at a pixel, of 20 a cell, from the upper left.
Vector2d on_board(const Layout& layout, int x, int y) {
  const double square = layout.marker_cells + 3;
  return {(x + 0.5) / 20 - square, static_cast<float>(layout.rows - 1) * square - (y + 0.5) / 20};
}

TEST(CharucoInk, IsTheBoardThatOpenCvDraws) {
  for (const Layout& layout : kLayouts) {
    const float square = static_cast<float>(layout.marker_cells) + 3;
    const BoardOfOpenCv theirs = charuco_of_opencv(
        {layout.columns, layout.rows, square, static_cast<float>(layout.marker_cells)},
        layout.dictionary, 20 * (layout.marker_cells + 3));
    const cv::Mat& picture = theirs.drawing;
    const Board board = board_of(layout, false);
    const auto ink = ink_cells(board, tag_family(layout.name, 1));
    int num_black = 0;
    for (int y = kStep / 2; y < picture.rows; y += kStep) {
      for (int x = kStep / 2; x < picture.cols; x += kStep) {
        const bool expected = picture.at<std::uint8_t>(y, x) == 0;
        num_black += expected;
        ASSERT_EQ(black(ink, on_board(layout, x, y)), expected)
            << layout.name << " at " << x << ' ' << y;
      }
    }
    EXPECT_GT(num_black, 1000);
    // The ids and the frame of OpenCV's corners, as docs/reference/formats.md says.
    const int columns = layout.columns - 1;
    for (const TargetPoint& point : target_points(board)) {
      const int i = point.id.tag_id;
      const int id = (layout.rows - 2 - i / columns) * columns + i % columns;
      const cv::Point3f& corner = theirs.corners[static_cast<std::size_t>(id)];
      EXPECT_NEAR(corner.x, point.position.x() + square, 1e-5);
      EXPECT_NEAR(corner.y, static_cast<float>(layout.rows - 1) * square - point.position.y(),
                  1e-5);
    }
    const std::vector<Tag> markers = tags_of(board);
    ASSERT_EQ(markers.size(), theirs.ids.size());
    for (std::size_t i = 0; i < markers.size(); ++i) {
      EXPECT_EQ(markers[i].id, theirs.ids[i]);
      const auto upper_left = tag_corners(markers[i])[3];
      EXPECT_NEAR(theirs.markers[i][0].x, upper_left.x() + square, 1e-5);
      EXPECT_NEAR(theirs.markers[i][0].y,
                  static_cast<float>(layout.rows - 1) * square - upper_left.y(), 1e-5);
    }
  }
}

// OpenCV before 4.6 (aruco's charuco.cpp): a square is black if its column and its row, counted
// from below, are both even or both odd; markers are counted from the uppermost row on.
TEST(CharucoInk, IsTheOldLayoutOfOpenCv) {
  for (const Layout& layout : kLayouts) {
    const Board board = board_of(layout, true);
    const std::vector<Tag> markers = tags_of(board);
    const auto ink = ink_cells(board, tag_family(layout.name, 1));
    const double square = layout.marker_cells + 3;
    int id = 0;
    for (int row = layout.rows - 1; row >= 0; --row) {
      for (int column = 0; column < layout.columns; ++column) {
        const Vector2d low = square * Vector2d(column - 1, row - 1);
        const bool expected = row % 2 == column % 2;
        EXPECT_EQ(black(ink, low + Vector2d(0.5, 0.5)), expected);  // outside of the marker
        if (expected) continue;
        const Tag& marker = markers[static_cast<std::size_t>(id)];
        EXPECT_EQ(marker.id, id++);
        EXPECT_LT(
            (marker.board_from_tag.translation().head<2>() - low - Vector2d::Constant(square / 2))
                .norm(),
            1e-12);
      }
    }
    // For an odd number of rows the old layout is the new one.
    const bool same =
        checkers(board)->starts_black == checkers(board_of(layout, false))->starts_black;
    EXPECT_EQ(same, layout.rows % 2 == 1);
  }
}

}  // namespace
}  // namespace tagcal
