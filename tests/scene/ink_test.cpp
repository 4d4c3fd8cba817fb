#include <apriltag/common/image_u8.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "apriltag_families.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

// Rectangles of ink or paper.
template <typename Corners>
bool inside(const Corners& r, double x, double y) {
  return x > r[0].x() && x < r[2].x() && y > r[0].y() && y < r[2].y();
}

bool black(const std::vector<InkCell>& ink, double x, double y) {
  return std::ranges::any_of(ink, [&](const InkCell& r) { return inside(r, x, y); });
}

template <typename Corners>
double area(const Corners& r) {
  return (r[1] - r[0]).cross(r[3] - r[0]).norm();
}

// Every family, cell by cell, against the pictures that the AprilTag library draws.
TEST(Ink, IsTheTagThatAprilTagDraws) {
  for (const AprilTagFamily& each : kAprilTagFamilies) {
    apriltag_family_t* theirs = each.create();
    const TagFamily family = as_tag_family(*theirs);
    for (const std::uint32_t id : {0u, 1u, theirs->ncodes - 1}) {
      const Tag tag{static_cast<int>(id), static_cast<double>(family.width_at_border), Pose()};
      const Board board = make_board(Tags{family.name, 1, {tag}});
      const auto ink = ink_cells(board, family);
      image_u8_t* picture = apriltag_to_image(theirs, id);
      const int n = family.total_width;
      double black_area = 0;
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          const bool expected = picture->buf[y * picture->stride + x] == 0;
          black_area += expected;
          EXPECT_EQ(black(ink, x + 0.5 - 0.5 * n, 0.5 * n - y - 0.5), expected)
              << family.name << " id " << id << " cell " << x << ' ' << y;
        }
      }
      double ink_area = 0;  // equal only if no two rectangles overlap
      for (const InkCell& r : ink) ink_area += area(r);
      EXPECT_NEAR(ink_area, black_area, 1e-9) << family.name;
      // The paper, which does not know the family, holds all the ink.
      const Rectangle paper = board_panels(board, 1e-9).front().paper;
      for (const InkCell& r : ink)
        for (const Vector3d& corner : r)
          EXPECT_TRUE(inside(paper, corner.x(), corner.y())) << family.name;
      image_u8_destroy(picture);
    }
    each.destroy(theirs);
  }
}

TEST(Ink, KalibrsBorderIsTwoCellsWide) {
  const Board board = make_board(AprilGrid{1, 1, 1.0, 0.3, 0});
  const auto ink = ink_cells(board, tag36h11_family());
  const TagFamily family = tag36h11_family();
  // Cells of a tenth of the tag: two rings black, the bits of the stock tag inside.
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) {
      bool expected = true;
      for (std::size_t i = 0; i < family.bits.size(); ++i)
        if (family.bits[i].x + 1 == x && family.bits[i].y + 1 == y)
          expected = (family.codes[0] >> (family.bits.size() - 1 - i) & 1) == 0;
      EXPECT_EQ(black(ink, 0.1 * x + 0.05, 0.95 - 0.1 * y), expected) << x << ' ' << y;
    }
  }
  const Board eighths = make_board(AprilGrid{1, 1, 1.0, 0.3, 0, "tag36h11", 1, true});
  EXPECT_FALSE(black(ink_cells(eighths, family), 0.19, 0.5) && black(ink, 0.21, 0.5) &&
               !black(ink, 0.19, 0.5));
  EXPECT_TRUE(black(ink, 0.19, 0.77));
}

TEST(Ink, KalibrsSquaresStandAtEveryCrossing) {
  const Board board = make_board(AprilGrid{6, 6, 0.088, 0.3, 0});
  const auto panels = board_panels(board, 0.02);
  ASSERT_EQ(panels.size(), 1u);
  ASSERT_EQ(panels[0].squares.size(), 49u);
  const auto ink = ink_cells(board, tag36h11_family());
  const double gap = 0.3 * 0.088;
  const double pitch = 1.3 * 0.088;
  for (int row = 0; row <= 6; ++row) {
    for (int column = 0; column <= 6; ++column) {
      // Just inside and just outside of the two corners on the diagonal.
      const double x = column * pitch;
      const double y = row * pitch;
      EXPECT_TRUE(black(ink, x - 1e-6, y - 1e-6));
      EXPECT_TRUE(black(ink, x - gap + 1e-6, y - gap + 1e-6));
      EXPECT_EQ(black(ink, x + 1e-6, y + 1e-6), row < 6 && column < 6);  // a tag's corner
      EXPECT_FALSE(black(ink, x + 1e-6, y - 1e-6));
    }
  }
  const Rectangle& paper = panels[0].paper;
  EXPECT_LT((paper[0] - Vector3d(-gap - 0.02, -gap - 0.02, 0)).norm(), 1e-12);
  EXPECT_LT((paper[2] - Vector3d(6 * pitch + 0.02, 6 * pitch + 0.02, 0)).norm(), 1e-12);
}

// How much of a square about a point is ink.
double ink_share(const std::vector<InkCell>& ink, double x, double y, double half) {
  double sum = 0;
  for (const InkCell& r : ink) {
    const double width = std::min(x + half, r[2].x()) - std::max(x - half, r[0].x());
    const double height = std::min(y + half, r[2].y()) - std::max(y - half, r[0].y());
    sum += std::max(0.0, width) * std::max(0.0, height);
  }
  return sum / (4 * half * half);
}

// Grown ink is where a square of the spread's half side meets the ink as designed, shrunk ink where
// the whole square is in it; and no two rectangles share an area.
TEST(Ink, SpreadsIntoTheWhite) {
  const TagFamily standard = tag_family("tagStandard41h12", 1);  // black cells beyond its corners
  const std::pair<Board, TagFamily> boards[] = {
      {make_board(AprilGrid{3, 2, 1.0, 0.3, 0}), tag36h11_family()},
      {make_board(AprilGrid{2, 2, 1.0, 0.25, 7, "tag36h11", 1, false}), tag36h11_family()},
      {make_board(AprilGrid{2, 1, 1.0, 1.2, 3, standard.name, 1, false}), standard},
      {make_board(Checkerboard{.columns = 3, .rows = 2, .column_spacing = 1, .row_spacing = 0.5}),
       {}},
      {make_board(Checkerboard{2, 2, 1, 1, false}), {}},
      {make_board(Charuco{4, 3, 1, 0.7, "tag36h11"}), tag36h11_family()}};
  for (const auto& [board, family] : boards) {
    const BoardPanel panel = board_panels(board, 0.1).front();
    const auto designed = ink_cells(board, panel, family);
    for (const double spread : {0.03, 0.002, -0.03}) {
      const auto ink = ink_cells(board, panel, family, spread);
      Random random(3);
      int compared = 0;
      for (int i = 0; i < 20000; ++i) {
        const double x = random.uniform(panel.paper[0].x(), panel.paper[2].x());
        const double y = random.uniform(panel.paper[0].y(), panel.paper[2].y());
        const double share = ink_share(designed, x, y, std::abs(spread));
        const int found = static_cast<int>(
            std::ranges::count_if(ink, [&](const InkCell& r) { return inside(r, x, y); }));
        const double edge = spread > 0 ? share : 1 - share;  // 0 but for rounding, or far from it
        if (edge > 1e-12 && edge < 1e-9) continue;
        ++compared;
        ASSERT_EQ(found, spread > 0 ? edge > 1e-12 : edge <= 1e-12)
            << family.name << ' ' << spread << " at " << x << ' ' << y;
      }
      EXPECT_GT(compared, 19900);
    }
  }
}

// Ten cells in 96 pixels of 0.01; the border has two cells.
TEST(Ink, CellsAreRoundedToThePixelsOfADrawing) {
  const Board board = make_board(Tags{"tag36h11", 2, {{0, 0.96, Pose()}}});
  const BoardPanel panel = board_panels(board, 0.1).front();
  const TagFamily family = tag36h11_family();
  std::set<long> from_left, from_above;
  for (const InkCell& cell : ink_cells(board, panel, family, 0, 0.01)) {
    for (const Vector3d& corner : cell) {
      const double x = 100 * (corner.x() + 0.48), y = 100 * (0.48 - corner.y());
      EXPECT_NEAR(x, std::round(x), 1e-9);
      EXPECT_NEAR(y, std::round(y), 1e-9);
      from_left.insert(std::lround(x));
      from_above.insert(std::lround(y));
    }
  }
  const std::set<long> expected = {0, 19, 29, 38, 48, 58, 67, 77, 96};
  EXPECT_EQ(from_left, expected);
  EXPECT_EQ(from_above, expected);
}

// Also of a tag whose side is no whole number of pixels; and ink spreads from the rounded edges.
TEST(Ink, RoundingKeepsCornersAndSpread) {
  const Board board = make_board(Tags{"tag36h11", 2, {{0, 0.955, Pose()}}});
  const BoardPanel panel = board_panels(board, 0.1).front();
  const TagFamily family = tag36h11_family();
  const InkCell border = ink_cells(board, panel, family, 0.002, 0.01).front();  // the upper side
  EXPECT_NEAR(border[3].x(), -0.4795, 1e-12);
  EXPECT_NEAR(border[2].x(), 0.4795, 1e-12);
  EXPECT_NEAR(border[2].y(), 0.4795, 1e-12);
  for (const double grid : {0.0955, -0.01, std::nan("")})
    EXPECT_THROW(ink_cells(board, panel, family, 0, grid), Error) << grid;
  EXPECT_NO_THROW(ink_cells(board, panel, family, 0.042, 0.01));
  EXPECT_THROW(ink_cells(board, panel, family, 0.043, 0.01), Error);
}

TEST(Ink, SpreadsNoFurtherThanEdgesMeet) {
  const Board kalibr = make_board(AprilGrid{2, 2, 1.0, 0.3, 0});  // cells of 0.1, gaps of 0.3
  const TagFamily family = tag36h11_family();
  const BoardPanel panel = board_panels(kalibr, 0.1).front();
  EXPECT_NO_THROW(ink_cells(kalibr, panel, family, 0.049));
  for (const double spread : {0.05, -0.05, std::nan("")})
    EXPECT_THROW(ink_cells(kalibr, panel, family, spread), Error) << spread;
  const Board near = make_board(AprilGrid{2, 2, 1.0, 0.06, 0, "tag36h11", 1, false});
  EXPECT_NO_THROW(ink_cells(near, board_panels(near, 0.1).front(), family, 0.029));
  EXPECT_THROW(ink_cells(near, board_panels(near, 0.1).front(), family, 0.031), Error);
  const Board checker = make_board(Checkerboard{3, 2, 1.0, 0.5});
  EXPECT_NO_THROW(ink_cells(checker, board_panels(checker, 0.1).front(), {}, 0.24));
  EXPECT_THROW(ink_cells(checker, board_panels(checker, 0.1).front(), {}, -0.25), Error);
  const Board charuco = make_board(Charuco{4, 3, 1, 0.9, "tag36h11"});
  EXPECT_NO_THROW(ink_cells(charuco, board_panels(charuco, 0.1).front(), family, 0.024));
  EXPECT_THROW(ink_cells(charuco, board_panels(charuco, 0.1).front(), family, 0.026), Error);
  // A corner of the second tag is 0.1 beside the first one's side.
  const Pose by_45(exp_rotation({0, 0, std::numbers::pi / 4}), {0.6 + std::sqrt(0.5), 0, 0});
  const Board turned = make_board(Tags{.tags = {{0, 1.0, Pose()}, {1, 1.0, by_45}}});
  const BoardPanel both = board_panels(turned, 0.1).front();
  EXPECT_NO_THROW(ink_cells(turned, both, family, 0.04));
  EXPECT_THROW(ink_cells(turned, both, family, 0.05), Error);
}

TEST(Ink, OneSheetOfPaperForAPlaneOneEachForACube) {
  const auto with_second = [](const Pose& pose) {
    return make_board(Tags{.tags = {{0, 0.1, Pose()}, {1, 0.1, pose}}});
  };
  auto panels = board_panels(with_second({exp_rotation({0, 0, 0.3}), {0.3, 0, 0}}), 0.01);
  ASSERT_EQ(panels.size(), 1u);
  EXPECT_NEAR(panels[0].paper[0].x(), -0.06, 1e-12);
  const double half_diagonal = 0.05 * (std::cos(0.3) + std::sin(0.3));
  EXPECT_NEAR(panels[0].paper[2].x(), 0.3 + half_diagonal + 0.01, 1e-12);
  const Pose side(exp_rotation({0, std::numbers::pi / 2, 0}), {0.05, 0, -0.05});
  panels = board_panels(with_second(side), 0.01);
  ASSERT_EQ(panels.size(), 2u);
  EXPECT_NEAR(area(panels[1].paper), 0.12 * 0.12, 1e-12);
  for (const Vector3d& corner : panels[1].paper) EXPECT_NEAR(corner.x(), 0.05, 1e-12);
}

TEST(Ink, RejectsWhatCannotBePrinted) {
  AprilGrid grid{1, 1, 0.1, 0.3, 587};
  EXPECT_THROW(ink_cells(make_board(grid), tag36h11_family()), Error);
  grid.first_id = 586;
  EXPECT_NO_THROW(ink_cells(make_board(grid), tag36h11_family()));
  EXPECT_THROW(ink_cells(make_board(Tags{"tag36h11", 0, {{586, 0.1}}}), tag36h11_family()), Error);
  grid.border_bits = 1;
  TagFamily reversed = tag36h11_family();
  reversed.reversed_border = true;
  EXPECT_THROW(ink_cells(make_board(grid), reversed), Error);
}

TEST(Checkerboard, InkIsEverySecondSquare) {
  for (const bool starts_black : {true, false}) {
    const Board board = make_board(Checkerboard{4, 3, 0.02, 0.03, starts_black});
    const auto ink = ink_cells(board, {});
    EXPECT_EQ(ink.size(), 10u);
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 5; ++column)
        EXPECT_EQ(black(ink, 0.02 * (column - 0.5), 0.03 * (row - 0.5)),
                  ((row + column) % 2 == 0) == starts_black);
    const BoardPanel panel = board_panels(board, 0.01).front();
    EXPECT_EQ(panel.points.size(), 12u);
    // The paper surrounds the white squares, too.
    EXPECT_LT((panel.paper[0] - Vector3d(-0.03, -0.04, 0)).norm(), 1e-15);
    EXPECT_LT((panel.paper[2] - Vector3d(0.09, 0.1, 0)).norm(), 1e-15);
  }
}

TEST(CircleGrid, InkHasTheAreaAndTheOutlineOfDiscs) {
  const Board board = make_board(CircleGrid{3, 2, 0.02, 0.012});
  const BoardPanel panel = board_panels(board, 0.01).front();
  EXPECT_LT((panel.paper[0] - Vector3d(-0.016, -0.016, 0)).norm(), 1e-15);
  EXPECT_LT((panel.paper[2] - Vector3d(0.056, 0.036, 0)).norm(), 1e-15);
  for (const double spread : {0.0, 0.001, -0.002}) {
    const auto ink = ink_cells(board, panel, {}, spread);
    ASSERT_EQ(ink.size(), 6u);
    const double radius = 0.006 + spread;
    double twice_area = 0;
    for (std::size_t i = 0; i < ink[4].size(); ++i) {
      const Vector3d a = ink[4][i] - panel.points[4].position;
      const Vector3d b = ink[4][(i + 1) % ink[4].size()] - panel.points[4].position;
      twice_area += a.cross(b).z();
      EXPECT_NEAR(a.norm(), radius, 6e-5 * radius);
      EXPECT_NEAR((a + b).norm() / 2, radius, 6e-5 * radius);
    }
    EXPECT_NEAR(twice_area / 2, std::numbers::pi * radius * radius, 1e-12);
  }
  EXPECT_THROW(ink_cells(board, panel, {}, 0.004), Error);
  EXPECT_THROW(ink_cells(board, panel, {}, -0.006), Error);
}

}  // namespace
}  // namespace tagcal
