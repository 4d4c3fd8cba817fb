#pragma once

#include <array>
#include <cstddef>

// Every number that decides which tags `detect` reports, where their corners are, and what it says
// of a picture, once: its unit, meaning and source. Rounding, sizes, steps of iterations and limits
// of work stand where they are used, on lines that say `// numeric:`. The kernels of tag_fit are
// compiled for one processor and do not include this header.

namespace tagcal::internal::policy {

// ---- Finding tags

// px by which black is shrunk before AprilTag looks, one search each: the corner squares of a
// Kalibr board touch the tags' corners and otherwise join them to one black shape. Source: test
// Detector.TagsOfKalibrBoards.
inline constexpr std::array<int, 3> kTagShrinksPx = {0, 1, 2};

// Range of grey levels in 12x12 px below which AprilTag takes them for one colour: in standard
// deviations of the noise, at least AprilTag's own default, and at most what a tag of low contrast
// has where the whole picture is finely textured. Source: 144 normal numbers have a range of 5.3 on
// average, and beyond 7 in 1 of 500 cases; without this bound most of AprilTag's time goes into
// flat, noisy parts. The largest: none; chosen by hand.
inline constexpr int kTagLeastRange = 5;
inline constexpr int kTagMostRange = 20;
inline constexpr double kTagNoiseRange = 7;

// Sides of a tag. Two sightings of one id whose centres are nearer are one tag, and a tag whose
// corners are nearer to where another tag of its plane predicts them is confirmed by it. Source:
// the centres of two tags are at least a side apart.
inline constexpr double kTagSameShare = 0.5;
// px from the picture's edge to a corner, at least. Source: none; chosen by hand. Test
// Detector.TagsAtTheEdgeOfThePictureAreLeftOut.
inline constexpr double kTagEdgeMarginPx = 1.5;
// px, the same for a tag whose pattern was not fitted: it may be the rest of a cut tag. Source:
// test Detector.WhatIsLeftOfATagThatTheEdgeCutsIsNoTag.
inline constexpr double kTagUnfittedEdgeMarginPx = 6;

// Grey levels between black and white, at least. Source: none; chosen by hand.
inline constexpr double kTagMinContrast = 8;

// Share of the Laplacian of the cells' levels that is added to them before they are read. Source:
// AprilTag 3's default of decode_sharpening.
inline constexpr double kTagDecodeSharpening = 0.25;

// Wrong bits that are accepted beyond DetectOptions::max_hamming if AprilTag has read the tag: its
// own reading has passed that bound already. Source: without it 0.1 % of the corners of worlds and
// 0.3 % of a real set are lost.
inline constexpr int kTagMoreWrongBitsIfFound = 2;
// Share of border and frame cells with the wrong colour, at most. Source: none; chosen by hand.
inline constexpr double kTagMaxWrongFixed = 0.1;

// ---- Fitting a tag's pattern

// Standard deviations of a corner. A fit has converged if the expected next step is smaller, and is
// final if the lens of the next round moves it by less: steps and rounds converge at least as fast
// as halving, so that less than this is left. It adds 0.3^2 / 2, 4 %, to a corner's variance at
// most.
inline constexpr double kConvergedSds = 0.3;
// px. Standard deviation of blur and a pixel's square together: usual (a blur of 0.8 px), and the
// bounds of a fit: a little more than the square alone (sqrt(1 / 12) = 0.289), and the largest
// blur. Source of the upper one: none; chosen by hand.
inline constexpr double kUsualSpreadPx = 0.85;
inline constexpr double kTagMinSpreadPx = 0.3;
inline constexpr double kTagMaxSpreadPx = 6;

// ---- Its four sides (refine_edges)

// px. A corner that moves farther belongs to something else: starts are good to 2 px. Source: none;
// chosen by hand.
inline constexpr double kTagMaxMovePx = 2;

// Prior standard deviation of the logarithm of the spread about kUsualSpreadPx. Source: none;
// chosen by hand.
inline constexpr double kEdgeLogBlurSd = 0.5;
// Prior standard deviation of the two grey levels, as a share of their difference. Source: none;
// chosen by hand.
inline constexpr double kEdgeLevelSdShare = 0.3;
// The prior standard deviations of the bends of a side, as a share of those of a whole tag
// (kTagBendSd, kTagTwistSd): a side by itself does not average them. Source: none; chosen by hand.
inline constexpr double kEdgeBendShare = 0.1;

// A step is felt up to this many spreads and half a pixel from it: the normal integral beyond is
// 0.6 %. The pixels of a side are used so far to either side, but no farther than kEdgeReachCells
// cells, where the next cell begins to matter; and not so near to its ends, where the next side
// disturbs the step, but for kEdgeMaxEndShare of either half. Source of the others: none; chosen by
// hand.
inline constexpr double kEdgeReachSpreads = 2.5;
inline constexpr double kEdgeReachCells = 0.65;
inline constexpr double kEdgeMaxEndShare = 0.6;
// Pixels of a side, at least. Source: none; chosen by hand.
inline constexpr std::size_t kEdgeMinPixels = 16;

// ---- Fitting a tag's pattern: the whole tag (refine_tag)

// px around a tag that are fitted, and px of each side next to the corner if corners are fitted by
// themselves. Source: none; chosen by hand with `corner_accuracy lens`.
inline constexpr double kTagOutsidePx = 16;
inline constexpr double kTagInsidePx = 40;

// Spreads (blur and pixel together) from a pixel to what is not known, at least: its influence is
// the normal integral beyond 3, 0.14 %.
inline constexpr double kTagUnknownReach = 3;

// Prior standard deviation of the shift of borders, px, each of ink and of bloom. Source: ink
// spreads by up to about 0.15 px; whites at 2.5 times the full exposure grow by 0.6 px, beyond this
// prior (docs/corners.md).
inline constexpr double kTagShiftSdPx = 0.1;
// Standard deviations of the prior. A single corner hardly tells a shift of its borders from its
// own place; a shift beyond this, 1 in 16,000 by a normal distribution, is a second minimum.
inline constexpr double kTagMaxShiftSds = 4;

// Prior standard deviation of the curvature that a lens gives to a line, in 1 / (longer side of the
// picture), and of its change along the line, in 1 / side^2. Source: a fisheye whose picture spans
// 190 degrees has a focal length of 0.3 sides and lines of curvature up to 0.6 / f, which is 2 /
// side. The second: a curvature that
// changes by its own size within a tenth of the side. Source: none; chosen by hand.
inline constexpr double kTagBendSd = 2;
inline constexpr double kTagTwistSd = 10 * kTagBendSd;
// px. Smaller pictures are taken for parts of one with this side. Source: none; chosen by hand.
inline constexpr double kTagSmallestPicturePx = 320;

// Squared, in prior standard deviations: mean over the four bends of second, or the eight of third
// order, beyond which larger bends are expected; and the factor by which these priors then widen,
// for each order. Source: chosen by hand with `corner_accuracy lens`: NEES of tags under a barrel
// of k1 = -0.4 fell from 1.83, 1.29, 1.42 (30, 40, 100 px) to 1.04, 0.94, 1.12.
inline constexpr double kTagStrongBends = 0.5;
inline constexpr double kTagStrongerBends = 2;

// px. A longer tag under an unknown lens is fitted corner by corner: a lens bends it beyond third
// order. Source: none; chosen by hand with `corner_accuracy lens`.
inline constexpr double kTagMaxWholePx = 110;
// A shorter tag is fitted corner by corner if it has this side (px), and bends of third order move
// a corner by this many px and by this many of the corner's standard deviations. Source: none;
// chosen by hand.
inline constexpr double kTagMinPartsPx = 36;
inline constexpr double kTagThirdOrderPx = 0.02;
inline constexpr double kTagThirdOrderSds = 8;
// Standard deviation that bends beyond third order add to the corners of a large tag fitted as a
// whole, as a share of what bends of third order do to them. Source: none; chosen by hand.
inline constexpr double kTagNextOrderShare = 0.25;

// Standard deviations of the start's homography as a prior, over a region of size 1: of places, of
// scales and turns, and of the perspective. Two lines around one corner do not determine the last
// two. Source: chosen by hand with `corner_accuracy lens`: of 60 fisheye tags 2 of 160 px and 5 of
// 250 px did not converge under a wider prior and smaller windows, with these all do.
inline constexpr double kTagPlaceSd = 0.15;
inline constexpr double kTagScaleSd = 0.05;
inline constexpr double kTagPerspectiveSd = 0.03;
// px. Half sides of the windows about one corner that are fitted in turn before the whole region.
// Source: none; chosen by hand with `corner_accuracy lens`.
inline constexpr std::array<double, 3> kTagWindowsPx = {9, 18, 32};
// Ratio of the residuals' variances, region over last window, beyond which the region shows
// something else and the window is the answer. Source: none; chosen by hand with `corner_accuracy
// lens`.
inline constexpr double kTagMaxVarianceGrowth = 1.7;
// Squared, in standard deviations of one corner: a smaller step of a region's only corner lets the
// next one decide by the corner alone. Source: none; chosen by hand.
inline constexpr double kTagCornerSettledSize = 1;
// Noise over contrast of a fit, at most; beyond, the picture does not show this pattern. Source:
// none; chosen by hand.
inline constexpr double kTagMaxNoiseShare = 0.15;
// px. Largest standard deviation of a corner's coordinate. Source: none; chosen by hand.
inline constexpr double kTagMaxSdPx = 0.5;
// Pixels of a fit, at least. Source: none; chosen by hand.
inline constexpr int kTagMinPixels = 64;

// Share of a side by which a corner may move under a roughly known lens, a third of a cell, if that
// is more than kTagMaxMovePx. Source: none; chosen by hand.
inline constexpr double kTagMaxRoughMoveShare = 0.04;

// ---- Fitting a tag's pattern: the gamma of a picture

// Number of tags from which gamma is estimated, and side of a tag that is large enough, px. Source:
// none; chosen by hand.
inline constexpr std::size_t kTagGammaTags = 2;
inline constexpr double kTagGammaMinSidePx = 45;
// Bounds of the logarithm of gamma (0.3 and 1.4). Source: cameras have 0.45 to 1.
inline constexpr double kTagMinLogGamma = -1.2;
inline constexpr double kTagMaxLogGamma = 0.35;
// Twice the log-likelihood ratio by which another gamma must beat 1. Source: none; chosen by hand
// (chi-square of one degree of freedom: 4e-8).
inline constexpr double kTagGammaSure = 30;

// ---- Completing boards

// Pixels of the smallest halved picture that is searched. Source: none; chosen by hand.
inline constexpr double kBoardMinHalvedPixels = 150'000;

// Tags nearest to a missing one from which its place is predicted. Source: none; chosen by hand.
inline constexpr std::size_t kBoardNeighbours = 4;
// Cells by which a prediction may be off. Source: none; chosen by hand.
inline constexpr double kBoardReachCells = 2;
// Refined corners are wrong if they lie farther than this many px (the search is no finer) from the
// quad of highest correlation, and have lost this much of the correlation: a lens that bends a tag
// costs some, too. Source: none; chosen by hand. Test CompleteBoard.ASeedThatWentAstrayIsSetRight.
inline constexpr double kBoardWrongCornerPx = 1;
inline constexpr double kBoardLostCorrelation = 0.02;
// Probability that random bits in a frame are taken for a tag that no other confirms: at most, and
// where other tags of its plane should be in the picture and are not. Source: chosen by hand with
// the study `false_tags` (without them every eleventh picture without tags showed one of tag16h5).
inline constexpr double kBoardMaxChance = 5e-4;
inline constexpr double kBoardMaxChanceIfRefuted = 1e-5;

// ---- The lens of a picture, from the tags of one panel

// Corners that determine lens and pose: twice as many equations (48) as the 14 parameters, and some
// of them may be wrong.
inline constexpr std::size_t kPanelMinCorners = 24;
// Prior standard deviations: of the logarithm of the focal length (about half the longer side of
// the picture), of the logarithm of fy / fx, of the principal point (in longer sides), and of k1 to
// k4 (a perspective's are 0.33 and less). Source: none; chosen by hand.
inline constexpr double kPanelLogFocalSd = 1;
inline constexpr double kPanelLogAspectSd = 0.01;
inline constexpr double kPanelCentreSd = 0.05;
inline constexpr double kPanelTermSd = 0.5;
// Floor of the robust spread of residuals, in standard deviations of the corners: below it no
// corner counts as an outlier. Source: none; chosen by hand.
inline constexpr double kPanelMinSpread = 0.1;
// Spreads beyond which weights fall (Cauchy's robust cost), and the largest spread of a
// checkerboard's corners, in their standard deviations, up to which they are fitted under the lens.
// Source: none; chosen by hand.
inline constexpr double kPanelTailSpreads = 3;
// px. Standard deviations of corners under a roughly known lens: of fitted tags, and of straight
// sides. Source: none; chosen by hand.
inline constexpr double kPanelFittedSdPx = 0.1;
inline constexpr double kPanelSidesSdPx = 1;
// Standard deviations of a corner from where the lens projects it, at most. Source: exp(-6^2 / 2)
// for one corner, 1 in 10^7 for four.
inline constexpr double kPanelOutlierSds = 6;

// ---- Explaining, and the warning of a wrong border

// A picture shows another kind of tags (family, border, mirrored, inverted) if it has this many
// times the tags of the target's kind, and this many if it has none of these: a single tag may be
// read by chance. Source: chosen by hand.
inline constexpr std::size_t kOtherTagsRatio = 2;
// Sides of a tag. Two spacings of a board that differ by more are different ones. Source: usual
// spacings, 0.2, 0.25 and 0.3, differ by 0.05.
inline constexpr double kSpacingTolerance = 0.04;

// ---- Finding checkerboards

// Grey levels between black and white on a circle about a junction, at least. Source: none; chosen
// by hand.
inline constexpr double kJunctionMinContrast = 12;
// Grey levels per px^2. Least root of minus the Hessian's determinant of the smoothed picture.
// Source: contrast C and spread s have C / (pi s^2); C = 15, s = 2.
inline constexpr double kJunctionMinStrength = 1.2;
// px. Radii of the circles that are tried. Source: none; chosen by hand with `checker_accuracy
// found`: 3 for squares of 10 px seen at 60 degrees, 5 and 8 for noise and blur.
inline constexpr std::array<double, 3> kJunctionRadiiPx = {5, 3, 8};
// Radians. Largest bend of a line at a junction, and least angle between two. Source: none; chosen
// by hand.
inline constexpr double kJunctionMaxBend = 0.6;
inline constexpr double kJunctionMinAngle = 0.25;
// Radians. Largest turn of a line from a junction to the next one. Source: none; chosen by hand.
inline constexpr double kGridMaxTurn = 0.45;
// Share of the distance to the next junction by which a prediction, also of a corner before its
// fit, may be off. Source: from a half on
// two predictions claim one junction; two thirds of that.
inline constexpr double kGridTolerance = 1.0 / 3;
// Share of a grid's outermost line that must be seen (of the fullest line) and fitted (of the
// board's line): with fewer the line is not the board's. Source: none; chosen by hand.
inline constexpr double kMinLineShare = 0.3;
// Share of a board's corners that must be fitted. Source: none; chosen by hand.
inline constexpr double kCheckerMinFitted = 0.6;
// px. Shorter side of the smallest squares that are fitted. Source: none; chosen by hand.
inline constexpr double kCheckerMinSidePx = 3;
// Squares beyond the next junction that are fitted with a corner: pixels before them are then
// known. Source: 3 spreads of 0.9 px for squares of 10 px.
inline constexpr double kCheckerBeyond = 0.3;
// Part of the outermost squares that is printed for sure. Source: none; chosen by hand.
inline constexpr double kCheckerOutside = 0.5;

}  // namespace tagcal::internal::policy
