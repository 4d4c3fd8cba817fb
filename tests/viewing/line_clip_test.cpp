
#include <gtest/gtest.h>

#include "tagcal/random.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

const Window kWindow{-2, 3, -1, 1};

TEST(Outcode, OfTheNineRegionsRowByRowFromTheTop) {
  const int expected[3][3] = {
      {0b1001, 0b1000, 0b1010}, {0b0001, 0b0000, 0b0010}, {0b0101, 0b0100, 0b0110}};
  const double xs[] = {-3, 0, 4}, ys[] = {2, 0, -2};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_EQ(outcode(kWindow, {xs[column], ys[row]}), expected[row][column]);
  EXPECT_EQ(outcode(kWindow, {-2, 1}), 0);  // the border is inside
}

TEST(ClipLine, WorkedByHand) {
  const auto both = [](const Segment2& s) {
    return std::pair(clip_line_cohen_sutherland(kWindow, s), clip_line_liang_barsky(kWindow, s));
  };
  for (const auto& result : {both({{-4, -2}, {4, 2}}).first, both({{-4, -2}, {4, 2}}).second}) {
    EXPECT_TRUE(result->from.isApprox(Vector2d(-2, -1)));
    EXPECT_TRUE(result->to.isApprox(Vector2d(2, 1)));
  }
  const auto inside = both({{0, 0}, {1, 0.5}});
  EXPECT_EQ(inside.first->to, Vector2d(1, 0.5));
  EXPECT_EQ(inside.second->from, Vector2d(0, 0));
  const auto around_the_corner = both({{-3, 0.5}, {-1, 2}});  // two regions, yet nothing inside
  EXPECT_FALSE(around_the_corner.first || around_the_corner.second);
  const auto along_the_border = both({{-5, 1}, {5, 1}});
  EXPECT_EQ(along_the_border.first->from, Vector2d(-2, 1));
  EXPECT_EQ(along_the_border.second->to, Vector2d(3, 1));
  const auto corner = both({{-3, 0}, {-1, 2}});  // through the upper left corner
  EXPECT_EQ(corner.first->from, Vector2d(-2, 1));
  EXPECT_EQ(corner.second->to, Vector2d(-2, 1));
  const auto point = both({{3, 0}, {3, 0}});
  EXPECT_TRUE(point.first && point.second);
  const auto outside = both({{4, 0}, {4, 0}});
  EXPECT_FALSE(outside.first || outside.second);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    const auto none = both({{bad, 0}, {1, 0}});
    EXPECT_FALSE(none.first || none.second);
  }
}

TEST(ClipLine, BothWaysAgreeAndWithTheCutInSpace) {
  const std::vector<HalfSpace> sides = {{{1, 0, 0}, kWindow.left},
                                        {{-1, 0, 0}, -kWindow.right},
                                        {{0, 1, 0}, kWindow.bottom},
                                        {{0, -1, 0}, -kWindow.top}};
  Random random(1);
  int visible = 0, cut = 0;
  for (int i = 0; i < 20000; ++i) {
    // Half of them on whole numbers, where the degenerate ones are.
    const bool grid = i % 2 != 0;
    const auto coordinate = [&] {
      const double x = random.uniform(-5, 5);
      return grid ? std::round(x) : x;
    };
    const Segment2 s{{coordinate(), coordinate()}, {coordinate(), coordinate()}};
    const auto a = clip_line_cohen_sutherland(kWindow, s);
    const auto b = clip_line_liang_barsky(kWindow, s);
    const Eigen::Vector3d from(s.from.x(), s.from.y(), 0), to(s.to.x(), s.to.y(), 0);
    const auto c = clip_segment(from, to, sides);
    const bool touches = a && (a->from - a->to).norm() < 1e-12 && s.from != s.to;
    const bool b_touches = b && (b->from - b->to).norm() < 1e-12;
    if (!touches && !b_touches) {
      ASSERT_EQ(a.has_value(), b.has_value());
    }
    ASSERT_EQ(b.has_value(), c.has_value());
    if (!a || !b) continue;
    EXPECT_LT((a->from - b->from).norm() + (a->to - b->to).norm(), 1e-12);
    EXPECT_LT((b->from - s.from - c->from * (s.to - s.from)).norm(), 1e-12);
    ++visible;
    cut += a->from != s.from || a->to != s.to;
  }
  EXPECT_GT(visible, 3000);
  EXPECT_GT(cut, 2000);
}

}  // namespace
}  // namespace tagcal
