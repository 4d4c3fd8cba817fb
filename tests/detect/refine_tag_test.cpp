#include "tagcal/detect/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "corner_tally.hpp"
#include "rendered_tag.hpp"
#include "tag_patch.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
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

// A drawing's pixels of which most are at the ends of the range, with its lines through middles of
// pixels: no spread is the best one, and most steps clip other pixels.
TEST(RefineTag, ADrawingOfTheWholeRange) {
  const TagPattern pattern = tag_pattern(tag_family("tag36h11", 1), 7, 1);
  constexpr double kCell = 37.5, kFrom = 60.5;
  const auto is_white = [&](double x, double y) {
    const auto cell = [](double at) {
      return std::clamp(static_cast<int>(std::floor((at - kFrom) / kCell)) + 1, 0, 9);
    };
    return pattern.cells[static_cast<std::size_t>(10 * cell(y) + cell(x))] == TagPattern::white;
  };
  Image8 image({421, 421});
  for (int y = 0; y < 421; ++y) {
    for (int x = 0; x < 421; ++x) {
      int quarters = 0;
      for (const double dx : {-0.25, 0.25})
        for (const double dy : {-0.25, 0.25}) quarters += is_white(x + dx, y + dy);
      image(x, y) = static_cast<std::uint8_t>(std::min(255, 64 * quarters));
    }
  }
  const double to = kFrom + 8 * kCell;
  const Corners truth = {{{kFrom, to}, {to, to}, {to, kFrom}, {kFrom, kFrom}}};
  Random random(8);
  for (const TagFitOptions& options : {kStraight, TagFitOptions()}) {
    const TagFit fit = refine_tag(image, pattern, moved(truth, 1.5, random), options);
    ASSERT_EQ(fit.status, TagFitStatus::converged);
    EXPECT_LE(fit.iterations, 22);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((fit.corners[i] - truth[i]).norm(), 0.05);
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
