#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/random.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Polygon = std::vector<Vector2d>;

// The part of a polygon with sign * (p[axis] - at) >= 0 (Sutherland & Hodgman).
Polygon cut(const Polygon& polygon, int axis, double at, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double ha = sign * (a[axis] - at), hb = sign * (b[axis] - at);
    if (ha >= 0) kept.push_back(a);
    if ((ha >= 0) != (hb >= 0)) kept.push_back(a + ha / (ha - hb) * (b - a));
  }
  return kept;
}

double area(const Polygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return std::abs(sum);
}

// By cutting the polygons to every cell.
ImageF shares_by_cutting(const std::vector<Polygon>& polygons, const ImageSize& size) {
  ImageF shares(size, 0.0f);
  for (const Polygon& polygon : polygons) {
    for (int y = 0; y < size.height; ++y) {
      const Polygon row = cut(cut(polygon, 1, y, 1), 1, y + 1, -1);
      for (int x = 0; x < size.width && !row.empty(); ++x)
        shares(x, y) += static_cast<float>(area(cut(cut(row, 0, x, 1), 0, x + 1, -1)));
    }
  }
  return shares;
}

ImageF shares_by_bands(const std::vector<Polygon>& polygons, const ImageSize& size, int rows) {
  Outlines outlines;
  for (const Polygon& polygon : polygons) outlines.add(polygon);
  ImageF shares({size.width, size.height + rows}, 0.0f);
  CoverageBand band(size.width, rows);
  for (int first = 0; first < size.height; first += rows) {
    band.move_to(first);
    band.accumulate(outlines.edges());
    const auto add = [&](int r, int begin, int end, float share) {
      ASSERT_LE(0, begin);
      ASSERT_LE(begin, end);
      ASSERT_LE(end, size.width);
      for (int x = begin; x < end; ++x) shares(x, first + r) += share;
    };
    band.drain(add);
    band.drain([](int, int, int, float) { FAIL() << "the band was not emptied"; });
  }
  return shares;
}

void expect_same(const std::vector<Polygon>& polygons, const ImageSize& size) {
  const ImageF expected = shares_by_cutting(polygons, size);
  for (const int rows : {1, 5, size.height}) {
    const ImageF shares = shares_by_bands(polygons, size, rows);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        ASSERT_NEAR(shares(x, y), expected(x, y), 1e-6)
            << x << " " << y << " of " << size.width << ", bands of " << rows;
  }
}

Polygon triangle(Random& random, const ImageSize& size) {
  Polygon corners;
  for (int i = 0; i < 3; ++i)
    corners.emplace_back(random.uniform(-0.3, 1.3) * size.width,
                         random.uniform(-0.3, 1.3) * size.height);
  return corners;
}

TEST(RenderCoverage, IsTheAreaOfPolygonsInCells) {
  Random random(1);
  for (const int width : {1, 2, 7, 8, 9, 63, 64, 65, 509, 510, 511, 512, 513, 600})
    for (int i = 0; i < 4; ++i)
      expect_same({triangle(random, {width, 17}), triangle(random, {width, 17})}, {width, 17});
}

TEST(RenderCoverage, HoldsOnCellBordersAndThinThings) {
  const ImageSize size{40, 12};
  expect_same({{{0, 0}, {40, 0}, {40, 12}, {0, 12}}}, size);
  expect_same({{{8, 3}, {16, 3}, {16, 5}, {8, 5}}, {{16, 3}, {40, 3}, {40, 5}, {16, 5}}}, size);
  expect_same({{{-5, 2.25}, {50, 2.25}, {50, 2.5}, {-5, 2.5}}}, size);
  expect_same({{{3.001, -5}, {3.002, 30}, {3.003, 30}, {3.002, -5}}}, size);
  expect_same({{{50, 1}, {60, 1}, {60, 9}}}, size);
  expect_same({{{-50, 1}, {-60, 1}, {-60, 9}}}, size);
  expect_same({{{-1e6, -1e6}, {1e6, -1e6}, {20, 8.5}}}, size);
}

// Cells between edges get one visit, and exactly no or full share.
TEST(RenderCoverage, FlatGroundIsVisitedInRuns) {
  Outlines outlines;
  outlines.add({{10.3, 0.5}, {900.7, 0.25}, {910.1, 7.5}, {13.9, 7.75}});
  CoverageBand band(1000, 8);
  band.accumulate(outlines.edges());
  int visits = 0, full = 0;
  band.drain([&](int r, int first, int last, float share) {
    if (r == 0 || r == 7) return;
    ++visits;
    if (last - first > 100) {
      ++full;
      EXPECT_EQ(share, 1.0f) << r;
    }
  });
  EXPECT_EQ(full, 6);
  EXPECT_LT(visits, 6 * 40);
}

}  // namespace
}  // namespace tagcal
