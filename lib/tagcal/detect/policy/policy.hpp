#pragma once

#include <array>
#include <cstddef>

// Every number that decides which tags `detect` reports, where their corners are, and what it says
// of a picture, once: its unit, meaning and source. Rounding, sizes, steps of iterations and limits
// of work stand where they are used, on lines that say `// numeric:`. The kernels of tag_fit are
// compiled for one processor and do not include this header.

namespace tagcal::internal::policy {

// ---- Finding tags

// px. A picture with a shorter side is not searched. Source: AprilTag 3.3.0 crashes on pictures of
// 2x2 px and smaller, of one row, and of 5x3 px if decimated.
inline constexpr int kTagMinPictureSidePx = 8;

// px. A picture with a longer side is searched for tags at half its size and less only; their
// corners are fitted in the picture itself. Source: AprilTag 3.3.0 ends the program from 32768 px
// on.
inline constexpr int kTagMaxPictureSidePx = 32767;

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

// Tags of a family up to which two wrong bits may be accepted: the decoding table has an entry of
// 16 bytes for three times tags * bits * (bits - 1). Source: AprilTag 3.3.0; 2115 tags of 41 bits
// take 166 MB, 42211 of 48 bits would take 4.6 GB.
inline constexpr unsigned kTagMaxCodesForTwo = 4096;

// Two tags of one id are the same tag if their centres are nearer than this share of the shorter
// side. Source: none; chosen by hand.
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

// Cells. The level of a cell is the mean of four samples at (+-this, +-this) from its centre.
// Source: none; chosen by hand.
inline constexpr double kTagCellSampleOffset = 0.28;
// Border and frame cells of one colour that determine a plane of levels; with fewer the payload's
// cells are used too. Source: none; chosen by hand.
inline constexpr int kTagMinFixedCells = 8;

// Steps of the search for the quad with the highest correlation: of the whole quad (cells), of
// single corners at first (cells), and the corners' last step (px). Source: none; chosen by hand.
inline constexpr double kTagSearchStepCells = 0.5;
inline constexpr double kTagCornerStepCells = 0.5;
inline constexpr double kTagCornerLastStepPx = 0.2;

// Share of border and frame cells with the wrong colour, at most. Source: none; chosen by hand.
inline constexpr double kTagMaxWrongFixed = 0.1;
// The same if AprilTag has read the tag: a hand may hide its frame. Source: none; chosen by hand.
inline constexpr double kTagMaxWrongFixedIfFound = 0.25;
// Wrong bits that are accepted beyond DetectOptions::max_hamming if AprilTag has read the tag: its
// own reading has passed that bound already. Source: none; chosen by hand.
inline constexpr int kTagMoreWrongBitsIfFound = 2;
// Wrong bits of a tag that counts as surely read, at most. Source: none; chosen by hand.
inline constexpr int kTagMaxWrongBitsIfSure = 1;

// ---- Fitting a tag's pattern: its four sides (refine_edges)

// px. A corner that moves farther belongs to something else: starts are good to 2 px. Source: none;
// chosen by hand.
inline constexpr double kTagMaxMovePx = 2;

// px. Standard deviation of a side's blur: expected before the fit (a sharp lens and a pixel's
// square), and at least (a little less than the square alone, sqrt(1 / 12)). Source: none; chosen
// by hand.
inline constexpr double kEdgeStartBlurPx = 0.85;
inline constexpr double kEdgeMinBlurPx = 0.25;
// Logarithm of the largest blur, px. Source: none; chosen by hand.
inline constexpr double kEdgeMaxLogBlur = 3;
// Prior standard deviation of the logarithm of the blur. Source: none; chosen by hand.
inline constexpr double kEdgeLogBlurSd = 0.5;
// Prior standard deviation of the two grey levels, as a share of their difference. Source: none;
// chosen by hand.
inline constexpr double kEdgeLevelSdShare = 0.3;
// Prior standard deviation of the curvature that a lens gives to a side, 1/px, and of its change
// along the side, 1/px^2. Source: none; chosen by hand for large tags near the rim of a distorted
// picture.
inline constexpr double kEdgeBendSdPerPx = 3e-4;
inline constexpr double kEdgeTwistSdPerPx2 = 2e-6;

// Grey levels squared. Floor of the pixels' variance: a little more than rounding's 1 / 12.
inline constexpr double kEdgeMinVariance = 0.1;

// Pixels that are used: to either side up to kEdgeReachBlurs blurs and kEdgeReachPx px, but at most
// kEdgeReachCells cells, where the next cell begins to matter. The reach is never below
// kEdgeLeastReachCells cells, which is clamped to [kEdgeLeastReachLowPx, kEdgeLeastReachHighPx]
// (about three rows of pixels). Source: none; chosen by hand.
inline constexpr double kEdgeReachBlurs = 2.5;
inline constexpr double kEdgeReachPx = 1;
inline constexpr double kEdgeReachCells = 0.65;
inline constexpr double kEdgeLeastReachCells = 0.8;
inline constexpr double kEdgeLeastReachLowPx = 1.2;
inline constexpr double kEdgeLeastReachHighPx = 1.6;
// Pixels near a side's ends are not used, where the next side disturbs the step: up to
// kEdgeEndBlurs blurs and kEdgeEndPx px, at most kEdgeMaxEndShare of half the side. Source: none;
// chosen by hand.
inline constexpr double kEdgeEndBlurs = 2.5;
inline constexpr double kEdgeEndPx = 0.5;
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

// px. Bounds of the spread: a little more than a pixel's square alone (sqrt(1 / 12) = 0.289), and
// the largest blur. Source of the upper one: none; chosen by hand.
inline constexpr double kTagMinSpreadPx = 0.3;
inline constexpr double kTagMaxSpreadPx = 6;
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
// side. Source of the second: none; chosen by hand.
inline constexpr double kTagBendSd = 2;
inline constexpr double kTagTwistSd = 20;
// px. Smaller pictures are taken for parts of one with this side. Source: none; chosen by hand.
inline constexpr double kTagSmallestPicturePx = 320;

// Squared, in prior standard deviations: sums over the four bends of second and the eight of third
// order beyond which larger bends are expected. Source: none; chosen by hand with `corner_accuracy
// lens`: NEES of tags under a barrel of k1 = -0.4 fell from 1.83, 1.29, 1.42 (30, 40, 100 px) to
// 1.04, 0.94, 1.12.
inline constexpr double kTagMaxSecondOrder = 2;
inline constexpr double kTagMaxThirdOrder = 3.5;
// Factor by which these priors then widen, for each order. Source: as above.
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
// Squared, in standard deviations. A fit has converged if the expected next step is smaller.
// Source: a third of a standard deviation; chosen by hand.
inline constexpr double kTagConvergedSize = 0.1;
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
// Logarithm of gamma: step of the search, and bounds (gammas of 0.3 and 1.4). Source: cameras have
// 0.45 to 1.
inline constexpr double kTagGammaStep = 0.35;
inline constexpr double kTagMinLogGamma = -1.2;
inline constexpr double kTagMaxLogGamma = 0.35;
// Twice the log-likelihood ratio by which another gamma must beat 1. Source: none; chosen by hand
// (chi-square of one degree of freedom: 4e-8).
inline constexpr double kTagGammaSure = 30;

// ---- Completing boards

// Pixels of the smallest halved picture that is searched. Source: none; chosen by hand.
inline constexpr double kBoardMinHalvedPixels = 150'000;
// Pixels of the largest picture that is doubled if it shows no tag at all. Source: none; chosen by
// hand for its time.
inline constexpr int kBoardMaxDoubledPixels = 1'500'000;
// Sides of a tag that are searched around its predicted place. Source: none; chosen by hand.
inline constexpr double kBoardSearchMarginSides = 1;
// A part of the picture larger than this share of it is searched as the whole picture. Source:
// none; chosen by hand.
inline constexpr double kBoardMaxPartShare = 0.6;
// Share of a side by which a predicted corner lies beyond the picture's edge: a tag is not looked
// for if it is farther out. Source: none; chosen by hand.
inline constexpr double kBoardCutShare = 0.15;

// Tags nearest to a missing one from which its place is predicted. Source: none; chosen by hand.
inline constexpr std::size_t kBoardNeighbours = 4;
// Cells by which a prediction may be off. Source: none; chosen by hand.
inline constexpr double kBoardReachCells = 2;
// px. Smallest cell of a tag that is looked for. Source: none; chosen by hand.
inline constexpr double kBoardMinCellPx = 0.9;
// Correlation of picture and pattern, at least. Source: none; chosen by hand.
inline constexpr double kBoardMinCorrelation = 0.5;
// Correlation from which on a found tag is not laid out again. Source: none; chosen by hand.
inline constexpr double kBoardSureCorrelation = 0.93;
// Refined corners are wrong if they lie farther than this many cells and px (the search is no
// finer) from the quad of highest correlation, and have lost this much of the correlation: a lens
// that bends a tag costs some, too. Source: none; chosen by hand. Test
// CompleteBoard.ASeedThatWentAstrayIsSetRight.
inline constexpr double kBoardWrongCornerCells = 0.35;
inline constexpr double kBoardWrongCornerPx = 1;
inline constexpr double kBoardLostCorrelation = 0.02;
// Sides of a tag between its corners and where another tag predicts them, up to which the other
// confirms it. Source: none; chosen by hand.
inline constexpr double kBoardConfirmedShare = 0.5;
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
// Spreads beyond which weights fall (Cauchy's robust cost). Source: none; chosen by hand.
inline constexpr double kPanelTailSpreads = 3;
// px. Standard deviations of corners under a roughly known lens: of fitted tags, and of straight
// sides. Source: none; chosen by hand.
inline constexpr double kPanelFittedSdPx = 0.1;
inline constexpr double kPanelSidesSdPx = 1;
// Standard deviations of a corner. A fit is final if the next lens moves it by less: rounds
// converge at least as fast as halving, so that less than this is left.
inline constexpr double kPanelConvergedSds = 0.3;
// Standard deviations of a corner from where the lens projects it, at most. Source: exp(-6^2 / 2)
// for one corner, 1 in 10^7 for four.
inline constexpr double kPanelOutlierSds = 6;

// ---- Explaining, and the warning of a wrong border

// Tags of another kind (family, border, mirrored, inverted) from which on a picture shows that
// kind: random patterns are read as one tag. Source: chosen by hand.
inline constexpr std::size_t kBoardMinOtherTags = 2;
// The other kind must have this many times the tags of the target's kind. Source: none; chosen by
// hand.
inline constexpr std::size_t kBoardOtherTagsRatio = 2;
// Pictures that are searched with the other border first: a border is wrong in all or in none.
// Source: none; chosen by hand for its time.
inline constexpr std::size_t kBoardBorderProbes = 3;
// px. A picture with a shorter side that shows no tag is called too small. Source: none; chosen by
// hand: a board of tags of 20 px hardly fits in.
inline constexpr int kBoardSmallPictureSidePx = 160;
// Pairs of tags that determine the spacing of a board, at least. Source: none; chosen by hand.
inline constexpr std::size_t kBoardMinGaps = 3;
// Sides of a tag by which the measured spacing may differ from the target's. Source: none; chosen
// by hand.
inline constexpr double kBoardSpacingTolerance = 0.04;
// Relative difference up to which the target's spacing is taken for the gap in metres. Source:
// none; chosen by hand.
inline constexpr double kBoardMetresTolerance = 0.2;

// ---- Finding checkerboards

// px. Shorter side of the smallest halved picture that is searched. Source: none; chosen by hand.
inline constexpr int kCheckerMinPicturePx = 100;
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
// px. Distances in which the next junction is looked for. Source: none; chosen by hand.
inline constexpr double kGridFirstReachPx = 16;
inline constexpr double kGridLastReachPx = 300;
// Share of the distance to the next junction by which a prediction may be off. Source: none; chosen
// by hand.
inline constexpr double kGridTolerance = 0.35;
// Share of the junctions of a grid's outermost line, against its fullest line, below which the line
// is not the board's. Source: none; chosen by hand.
inline constexpr double kGridMinLineShare = 0.34;
// Share of a board's corners that must be fitted, and of each outermost line. Source: none; chosen
// by hand.
inline constexpr double kCheckerMinFitted = 0.6;
inline constexpr double kCheckerMinFittedOutside = 0.3;
// px. Shorter side of the smallest squares that are fitted. Source: none; chosen by hand.
inline constexpr double kCheckerMinSidePx = 3;
// Squares beyond the next junction that are fitted with a corner: pixels before them are then
// known. Source: 3 spreads of 0.9 px for squares of 10 px.
inline constexpr double kCheckerBeyond = 0.3;
// Part of the outermost squares that is printed for sure. Source: none; chosen by hand.
inline constexpr double kCheckerOutside = 0.5;
// Share of a square by which a corner may move from its prediction.
// Source: none; chosen by hand.
inline constexpr double kCheckerMaxMove = 0.3;
// Squares up to which a corner is predicted from markers and other corners. Source: none; chosen by
// hand.
inline constexpr double kCheckerNearSquares = 1.6;
inline constexpr double kCheckerLocalSquares = 2.3;
// Spread of the corners about the lens of the picture, in their standard deviations, up to which
// they are fitted under it. Source: none; chosen by hand.
inline constexpr double kCheckerMaxSpread = 2.5;

}  // namespace tagcal::internal::policy
