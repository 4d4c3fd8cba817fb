#include "tagcal/detect/tag_fit/tag_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"

namespace tagcal::internal {
namespace {

TagParameters bent_parameters() {
  TagParameters parameters;
  parameters << 0.42, 0.21, 0.5, -0.1, 0.51, 0.48, 0.03, -0.02, std::log(0.9), 30, 180, 6, -4, 0.03,
      -0.04,  //
      2e-3, -3e-3, 1e-3, 2e-3, 1e-3, -2e-3, 1e-3, 2e-3, -1e-3, 1e-3, 2e-3, -1e-3;
  return parameters;
}

// Pixels of a row that know of the geometry, at most one block.
void fill(TagBlock& block, TagModel& model, const TagParameters& parameters, const TagRow& row) {
  model.set(parameters);
  const std::vector<float> levels(60 + kTagPack);
  std::array<TagFlatSums, 2> flat{};
  model.select(row, levels.data(), 3, 0, 60, flat.data());
  block.size = block.num_felt = 0;
  block.is_bent = true;
  for (int c = 0; c < 60; ++c)
    if (model.seen(c) >= kSeenLine) model.add(block, c, 1, c);
}

constexpr double kTestScale = 25;
const TagPattern kTestPattern = tag_pattern(tag_family("tag36h11", 1), 7, 2, {0.3, true});
const TagGrid kTestGrid = {kTestPattern.lines, kTestPattern.lines, kTestPattern.cells};

// Derivatives against differences of the model, under tilt, bend and shading. That junctions change
// where lines turn against each other is left out of them: it is below 3 % of any.
TEST(TagKernels, Derivatives) {
  TagModel model(kTestGrid, kTestScale);
  const TagParameters parameters = bent_parameters();
  TagBlock block;
  TagDerivatives derivatives, moved;
  TagParameters squares = TagParameters::Zero(), errors = TagParameters::Zero();
  for (double y = -0.9; y < 0.9; y += 0.07) {
    const TagRow row{-1.2, 1 / kTestScale, y, {}};
    fill(block, model, parameters, row);
    model.evaluate(block, derivatives);
    // Minus the level, of the same pixels.
    const auto residual = [&](const TagParameters& at) {
      model.set(at);
      model.evaluate(block, moved);
      return Eigen::VectorXf(Eigen::Map<Eigen::VectorXf>(moved.columns[kTagResidual], block.size));
    };
    for (int i = 0; i < tag_parameter::kCount; ++i) {
      const TagParameters step = TagParameters::Unit(i) * (i >= 9 && i < 13 ? 1 : 4e-3);
      const Eigen::VectorXf difference =
          (residual(parameters - step) - residual(parameters + step)) /
          static_cast<float>(2 * step[i]);
      const Eigen::VectorXf derivative = Eigen::Map<Eigen::VectorXf>(
          derivatives.columns[i < kTagResidual ? i : i + 1], block.size);
      squares[i] += static_cast<double>(derivative.squaredNorm());
      errors[i] += static_cast<double>((derivative - difference).squaredNorm());
    }
  }
  for (int i = 0; i < tag_parameter::kCount; ++i) {
    EXPECT_GT(squares[i], 0) << "parameter " << i;
    EXPECT_LT(std::sqrt(errors[i] / squares[i]), 0.03) << "parameter " << i;
  }
}

// The kernels of any processor say the same to rounding, and sum what they say.
TEST(TagKernels, SumProducts) {
  TagModel model(kTestGrid, kTestScale);
  TagBlock block;
  TagDerivatives derivatives;
  fill(block, model, bent_parameters(), {-1.2, 1 / kTestScale, 0.11, {}});
  ASSERT_GT(block.size, 30);
  ASSERT_NE(block.size % kTagPack, 0);
  model.evaluate(block, derivatives);
  std::array<std::array<double, kTagColumns * kTagColumns>, 2> sums{};
  kPortableTagKernels.add_products(derivatives, sums[0].data());
  fastest_tag_kernels().add_products(derivatives, sums[1].data());
  for (std::size_t i = 0; i < kTagColumns; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0, size = 0;
      for (int n = 0; n < block.size; ++n) {
        const double product = static_cast<double>(derivatives.columns[i][n]) *
                               static_cast<double>(derivatives.columns[j][n]);
        sum += product;
        size += std::abs(product);
      }
      EXPECT_NEAR(sums[0][i * kTagColumns + j], sum, 1e-6 * size);
      EXPECT_NEAR(sums[1][i * kTagColumns + j], sum, 1e-6 * size);
    }
  }
}

// Pixels of one colour at the end of the range are clipped where the model is beyond it.
TEST(TagKernels, PixelsAtTheEndsOfTheRange) {
  TagTable table{};
  table.black = 20;
  table.gain = 234;
  table.gain_by_x = 40;  // of 255 at x = 0.025
  table.least_level = 0;
  table.full_level = 255;
  TagBlock block;
  block.size = 45;
  TagFlatSums expected{};
  for (int n = 0; n < block.size; ++n) {
    block.x[n] = static_cast<float>(n) / 45 - 0.5F;
    block.y[n] = 0.5F;
    block.level[n] = 255;
    const double r = 1 - 40 * static_cast<double>(block.x[n]);
    if (r < 0) continue;
    ++expected.n;
    expected.yr += r / 2;
    expected.rr += r * r;
  }
  ASSERT_GT(expected.n, 20);
  for (const TagKernels* kernels : {&kPortableTagKernels, &fastest_tag_kernels()}) {
    TagFlatSums white{}, black{};
    kernels->add_ends(table, block, true, &white);
    EXPECT_EQ(white.n, expected.n);
    EXPECT_NEAR(white.yr, expected.yr, 1e-5 * expected.yr);
    EXPECT_NEAR(white.rr, expected.rr, 1e-5 * expected.rr);
    kernels->add_ends(table, block, false, &black);
    EXPECT_EQ(black.n, 45);
    EXPECT_NEAR(black.r, 45 * 235, 1e-2);
  }
}

// A straight edge has the profile of the normal integral, with either kernels.
TEST(TagKernels, Profiles) {
  TagTable table{};
  table.per_unit = 1;
  table.gain = 1;
  table.gamma = 1;
  table.least_level = -1;
  table.full_level = 2;
  for (TagAxis* axis : {&table.columns, &table.rows}) {
    std::fill(std::begin(axis->lines), std::end(axis->lines), TagLine{1, 0, -1e4F, 0, 1, {}});
    axis->count = 3;
  }
  table.columns.lines[0].by_1 = 20;
  table.columns.lines[1].by_1 = 0;
  table.cells[0] = 2;  // white from the line on
  TagBlock block;
  TagDerivatives derivatives;
  for (const TagKernels* kernels : {&kPortableTagKernels, &fastest_tag_kernels()}) {
    block.size = 45;
    block.num_felt = 1;
    for (int n = 0; n < block.size; ++n) {
      block.x[n] = static_cast<float>(n) / 6 - 3.7F;
      block.y[n] = block.level[n] = 0;
      block.column[n] = block.row[n] = 1;
    }
    kernels->evaluate(table, block, derivatives);
    for (int n = 0; n < block.size; ++n) {
      const double x = static_cast<double>(block.x[n]);
      EXPECT_NEAR(derivatives.columns[10][n], 0.5 * std::erfc(-x / std::sqrt(2.0)), 5e-6) << x;
      EXPECT_NEAR(derivatives.columns[2][n],
                  std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi), 5e-6)
          << x;
    }
  }
}

}  // namespace
}  // namespace tagcal::internal
