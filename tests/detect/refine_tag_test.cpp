#include "tagcal/detect/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "corner_tally.hpp"
#include "rendered_tag.hpp"
#include "tag_patch.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr TagFitOptions kStraight = {0, 0, 12,
                                     nullptr};  // no lens bends the pictures of tag_patch()

// What the fit is told of the surroundings, and of the lens.
struct Known {
  TagSurroundings surroundings;
  TagFitOptions options = kStraight;
};

Trials trials(const TagViewSpec& spec, int count, const Known& known = {}) {
  Random random(31);
  const TagFamily family = tag_family(spec.family, 1);
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const TagView view = rendered_tag(spec, random);
    const TagPattern pattern = tag_pattern(family, view.id, spec.border_bits, known.surroundings);
    tally.add(refine_tag(view.image, pattern, moved(view.corners, 0.2, random), known.options),
              view.corners);
  }
  return tally.result();
}

TEST(RefineTag, PatternOfATag) {
  const TagFamily family = tag_family("tag36h11", 1);
  const TagPattern plain = tag_pattern(family, 3, 1);
  ASSERT_EQ(plain.lines.size(), 11u);
  EXPECT_DOUBLE_EQ(plain.lines.front(), -0.125);
  EXPECT_DOUBLE_EQ(plain.lines.back(), 1.125);
  const auto at = [](const TagPattern& pattern, std::size_t column, std::size_t row) {
    return pattern.cells[row * (pattern.lines.size() - 1) + column];
  };
  EXPECT_EQ(at(plain, 0, 0), TagPattern::white);
  EXPECT_EQ(at(plain, 1, 1), TagPattern::black);
  for (std::size_t i = 0; i < family.bits.size(); ++i) {
    const bool white = (family.codes[3] >> (family.bits.size() - 1 - i) & 1U) != 0;
    EXPECT_EQ(at(plain, static_cast<std::size_t>(family.bits[i].x + 1),
                 static_cast<std::size_t>(family.bits[i].y + 1)),
              white ? TagPattern::white : TagPattern::black);
  }
  const TagPattern kalibr = tag_pattern(family, 3, 2, {0.3, true});
  ASSERT_EQ(kalibr.lines.size(), 13u);
  EXPECT_DOUBLE_EQ(kalibr.lines.front(), -0.3);
  EXPECT_EQ(at(kalibr, 0, 0), TagPattern::black);
  EXPECT_EQ(at(kalibr, 1, 0), TagPattern::white);
  const TagPattern unknown_gap = tag_pattern(family, 3, 2, {0, true});
  EXPECT_EQ(at(unknown_gap, 0, 0), TagPattern::unknown);
  EXPECT_EQ(at(unknown_gap, 1, 0), TagPattern::white);
  EXPECT_THROW(tag_pattern(family, 587, 1), Error);
}

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
TEST(RefineTag, Derivatives) {
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
TEST(RefineTag, Kernels) {
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

// A straight edge has the profile of the normal integral, with either kernels.
TEST(RefineTag, Profiles) {
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

// Bounds are 1.2 times the Cramer-Rao bound of the model (benchmarks/corner_accuracy).
TEST(RefineTag, CornersAndTheirCovariance) {
  struct Case {
    TagViewSpec spec;
    double rms_px;
    int count;
  };
  for (const auto& [spec, rms_px, count] :
       {Case{{20, 30, 0.8, 2}, 0.0134, 60}, Case{{40, 30, 0.8, 2}, 0.0060, 60},
        Case{{40, 60, 0.8, 2}, 0.0085, 60}, Case{{40, 30, 0.3, 2}, 0.0039, 60},
        Case{{40, 30, 1.5, 2}, 0.0098, 60}, Case{{40, 30, 0.8, 8}, 0.0238, 60},
        Case{{100, 30, 0.8, 2}, 0.0036, 30}}) {
    const Trials t = trials(spec, count);
    EXPECT_EQ(t.failed, 0) << spec.side_px;
    EXPECT_LT(t.rms, rms_px) << spec.side_px << " px, tilt " << spec.tilt_deg;
    EXPECT_NEAR(t.predicted / t.rms, 1, 0.12) << spec.side_px << " px, tilt " << spec.tilt_deg;
    EXPECT_NEAR(t.nees, 1, 0.25) << spec.side_px << " px, tilt " << spec.tilt_deg;
    // Three standard deviations of a mean over four corners of each tag.
    const double limit = 3 * rms_px / std::sqrt(count);
    EXPECT_LT(t.mean.cwiseAbs().maxCoeff(), limit);
    EXPECT_LT(std::abs(t.outwards), limit);
  }
}

// The model draws what the renderer draws: what is left over of a picture without noise is its
// rounding.
TEST(RefineTag, TheModelIsTheRenderer) {
  Random random(3);
  const TagFamily family = tag_family("tag36h11", 1);
  for (const double tilt : {0.0, 30.0, 60.0}) {
    const TagView view = rendered_tag({60, tilt, 0.8, 0}, random);
    const TagFit fit =
        refine_tag(view.noiseless, tag_pattern(family, view.id, 1), view.corners, kStraight);
    ASSERT_EQ(fit.status, TagFitStatus::converged);
    EXPECT_LT(fit.noise_levels, 0.3);
    EXPECT_NEAR(fit.blur_px, 0.8, 1e-3);
    EXPECT_NEAR(fit.black, 30, 0.1);
    EXPECT_NEAR(fit.white, 220, 0.1);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((fit.corners[i] - view.corners[i]).norm(), 0.003) << tilt;
  }
}

// The blur comes in over several steps, and with it what is not known reaches farther in: 0.02 px.
TEST(RefineTag, AStrongBlurIsTheRenderersToo) {
  Random random(3);
  const TagFamily family = tag_family("tag36h11", 1);
  for (const double side : {60.0, 100.0, 200.0}) {
    const TagView view = rendered_tag({side, 20, 3, 0}, random);
    const TagFit fit =
        refine_tag(view.noiseless, tag_pattern(family, view.id, 1), view.corners, kStraight);
    ASSERT_EQ(fit.status, TagFitStatus::converged);
    EXPECT_LT(fit.noise_levels, 0.3) << side;
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((fit.corners[i] - view.corners[i]).norm(), 0.01) << side;
  }
}

TEST(RefineTag, OtherPatterns) {
  TagViewSpec spec;
  for (const char* family : {"tag25h9", "tag16h5", "tagStandard41h12"}) {
    spec.family = family;
    const Trials t = trials(spec, 40);
    EXPECT_EQ(t.failed, 0) << family;
    EXPECT_NEAR(t.predicted / t.rms, 1, 0.12) << family;
    EXPECT_NEAR(t.nees, 1, 0.25) << family;
  }
}

TEST(RefineTag, KalibrsSquares) {
  TagViewSpec spec;
  spec.border_bits = 2;
  spec.corner_squares = true;
  const Trials known = trials(spec, 40, {{0.3, true}});
  const Trials unknown = trials(spec, 40, {{0, true}});
  EXPECT_EQ(known.failed + unknown.failed, 0);
  EXPECT_NEAR(known.nees, 1, 0.25);
  EXPECT_NEAR(unknown.nees, 1, 0.25);
  EXPECT_LT(known.rms, 0.7 * unknown.rms);
  EXPECT_LT(std::abs(unknown.outwards), 0.003);
}

// Not to know the lens costs accuracy, and the covariance says so.
TEST(RefineTag, BendsThatAreNotThere) {
  const TagViewSpec spec{60, 30, 0.8, 2};
  const Trials straight = trials(spec, 30);
  const Trials bent = trials(spec, 30, {{}, TagFitOptions()});
  EXPECT_GT(bent.rms, straight.rms);
  EXPECT_GT(bent.predicted, 1.2 * straight.predicted);
  EXPECT_NEAR(bent.predicted / bent.rms, 1, 0.2);
}

// A corner just beyond the picture's edge is found there, and is not in the picture.
TEST(RefineTag, ACornerBesideThePictureIsOutOfIt) {
  Random random(6);
  const TagFamily family = tag_family("tag36h11", 1);
  int found_outside = 0;
  for (int i = 0; i < 10; ++i) {
    const Patch patch = tag_patch(family, 0, PatchSpec(), random);
    double left = 1e9;
    for (const Eigen::Vector2d& corner : patch.corners) left = std::min(left, corner.x());
    const int cut = static_cast<int>(std::ceil(left + 0.5));  // it lies up to 1 px beside the rest
    const ImageView8 whole = patch.image;
    const ImageView8 rest(whole.row(0) + cut, {whole.width() - cut, whole.height()},
                          whole.stride());
    Corners start = patch.corners;
    for (Eigen::Vector2d& corner : start) corner.x() = std::max(corner.x() - cut, -0.4);
    const TagFit fit = refine_tag(rest, tag_pattern(family, 0, 1), start);
    EXPECT_NE(fit.status, TagFitStatus::converged) << i;
    found_outside += fit.status == TagFitStatus::out_of_image;
  }
  EXPECT_GE(found_outside, 5);
}

TEST(RefineTag, WhatCannotBeFitted) {
  Random random(5);
  const TagFamily family = tag_family("tag36h11", 1);
  const Patch patch = tag_patch(family, 0, PatchSpec(), random);
  const auto status = [&](int id, const Corners& start) {
    const TagFit fit = refine_tag(patch.image, tag_pattern(family, id, 1), start);
    return fit.status;
  };
  EXPECT_EQ(status(0, patch.corners), TagFitStatus::converged);
  EXPECT_EQ(status(1, patch.corners), TagFitStatus::not_converged);  // another tag's bits
  Corners turned = patch.corners;
  std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  EXPECT_EQ(status(0, turned), TagFitStatus::not_converged);
  Corners outside = patch.corners;
  for (Eigen::Vector2d& corner : outside) corner.x() -= 60;
  EXPECT_EQ(status(0, outside), TagFitStatus::out_of_image);
  Corners tiny;
  for (std::size_t i = 0; i < 4; ++i)
    tiny[i] = patch.corners[0] + 0.05 * (patch.corners[i] - patch.corners[0]);
  EXPECT_NE(status(0, tiny), TagFitStatus::converged);
  const Corners point = {patch.corners[0], patch.corners[0], patch.corners[0], patch.corners[0]};
  EXPECT_NE(status(0, point), TagFitStatus::converged);

  const Image8 flat(patch.image.size(), 128);
  EXPECT_EQ(refine_tag(flat, tag_pattern(family, 0, 1), patch.corners).status,
            TagFitStatus::not_converged);
  TagPattern wrong = tag_pattern(family, 0, 1);
  wrong.cells.pop_back();
  EXPECT_THROW(refine_tag(flat, wrong, patch.corners), Error);
}

TEST(RefineTag, SixteenBits) {
  Random random(6);
  const TagFamily family = tag_family("tag36h11", 1);
  const Patch patch = tag_patch(family, 2, PatchSpec(), random);
  Image16 deep(patch.image.size());
  for (int y = 0; y < deep.height(); ++y)
    for (int x = 0; x < deep.width(); ++x)
      deep(x, y) = static_cast<std::uint16_t>(200 * patch.image(x, y));
  const TagPattern pattern = tag_pattern(family, 2, 1);
  const TagFit shallow = refine_tag(patch.image, pattern, patch.corners);
  const TagFit fit = refine_tag(deep, pattern, patch.corners);
  ASSERT_EQ(fit.status, TagFitStatus::converged);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((fit.corners[i] - shallow.corners[i]).norm(), 1e-4);
  EXPECT_NEAR(fit.noise_levels, 200 * shallow.noise_levels, 0.5);
}

}  // namespace
}  // namespace tagcal
