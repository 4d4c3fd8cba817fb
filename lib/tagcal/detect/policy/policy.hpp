#pragma once

#include <array>
#include <cstddef>

// Every number that decides which tags `detect` reports, where their corners are, and what it says
// of a picture, once: its unit, meaning and source (a paper, a probability, geometry, or what it
// does to the corners of docs/trust/sensitivity.md, for the constant x0.7 and x1.4). Rounding,
// sizes, steps of iterations and limits of work stand where they are used, on lines that say
// `// numeric:`. The kernels of tag_fit are compiled for one processor and do not include this
// header.

namespace tagcal::internal::policy {

// ---- Finding tags

// px by which black is shrunk before AprilTag looks, one search each: the corner squares of a
// Kalibr board touch the tags' corners and otherwise join them to one black shape. Source: test
// Detector.TagsOfKalibrBoards.
inline constexpr std::array<int, 3> kTagShrinksPx = {0, 1, 2};

// Standard deviations of a picture's noise. Range of grey levels in 12x12 px below which AprilTag
// takes them for one colour. Source: 144 normal numbers have a range of 5.3 on average, and beyond
// 7 in 1 of 500 cases; without it most of AprilTag's time goes into flat, noisy parts.
inline constexpr double kTagNoiseRange = 7;

// Sides of a tag. Two sightings of one id whose centres are nearer are one tag, and a tag whose
// corners are nearer to where another tag of its plane predicts them is confirmed by it. Source:
// the centres of two tags are at least a side apart.
inline constexpr double kTagSameShare = 0.5;
// px from the picture's edge to a corner, at least. Source: test
// Detector.TagsAtTheEdgeOfThePictureAreLeftOut.
inline constexpr double kTagEdgeMarginPx = 1.5;
// px, the same for a tag whose pattern was not fitted: it may be the rest of a cut tag. Source:
// test Detector.WhatIsLeftOfATagThatTheEdgeCutsIsNoTag.
inline constexpr double kTagUnfittedEdgeMarginPx = 6;

// Ratio of the levels of two of the four phases of 2x2 pixels in the brighter half of a picture,
// beyond which it is a raw mosaic. Source: daylight on grey paper has 1.3 to 2.5 behind the filters
// of a sensor; pictures without a mosaic have 1.00 (medians over a thousand blocks).
inline constexpr double kMosaicRatio = 1.1;
// Standard deviations by which each of the two medians may be wrong, in the direction that makes a
// mosaic of a picture without one. Source: test ImageFilters.OnlyAMosaicOfSmallPicturesIsOne (four
// such pictures of 400 at most).
inline constexpr double kMosaicSigmas = 3;
// Pixels between the lowest and the highest eighth of a picture's range, over steps from one to the
// other within one pixel, below which it has two levels. Source: rendered and real grey pictures
// have 6 and more, binarised ones none, and 0.03 after JPEG of quality 50. x0.7 and x1.4: nothing.
inline constexpr double kMostBetweenLevels = 1.0 / 3;

// Grey levels between black and white of tags and about junctions, at least. Source: x0.7 and
// x1.4: nothing.
inline constexpr double kMinContrast = 8;

// Share of the Laplacian of the cells' levels that is added to them before they are read. Source:
// AprilTag 3's default of decode_sharpening.
inline constexpr double kTagDecodeSharpening = 0.25;

// Wrong bits that are accepted beyond DetectOptions::max_hamming if AprilTag has read the tag: its
// own reading has passed that bound already. Source: without it 0.1 % of the corners of worlds and
// 0.3 % of a real set are lost.
inline constexpr int kTagMoreWrongBitsIfFound = 2;
// Share of border and frame cells with the wrong colour, at most. Source: tags of the other border
// have a whole ring of them (tests WrongBorder.*).
inline constexpr double kTagMaxWrongFixed = 0.1;

// ---- Fitting a tag's pattern

// Standard deviations. A corner farther from where the lens of the picture projects it is an
// outlier: by a normal distribution one coordinate in 1.7 million exceeds it. The claims of corners
// are too small if the number of corners that scatter by more than the median of their claims
// exceeds half of them by this many standard deviations.
inline constexpr double kOutlierSds = 5;
// Standard deviations of a corner. A fit has converged if the expected next step is smaller, and
// is final if the lens of the next round moves it by less: steps and rounds converge at least as
// fast as halving, so that less than this is left. Source: x0.7: corners -0.1 %, errors +0.1 %,
// squares over claims +0.2 %, -5 beyond 5 sd; x1.4: errors +0.5 %, squares over claims +0.7 %.
inline constexpr double kConvergedSds = 0.3;
// px. Standard deviation of blur and a pixel's square together: usual (a blur of 0.8 px), and
// the bounds of a fit: a little more than the square alone (sqrt(1 / 12) = 0.289), and the
// largest blur, which only ends the iteration. Source: x0.7: errors -0.6 %, squares over claims
// +0.1 %; x1.4: corners -0.1 %, errors +2.5 %, squares over claims +0.2 %.
inline constexpr double kUsualSpreadPx = 0.85;
inline constexpr double kTagMinSpreadPx = 0.3;
inline constexpr double kTagMaxSpreadPx = 6;

// ---- Its four sides (refine_edges)

// px. A corner that moves farther belongs to something else: starts are good to 2 px. Source:
// x0.7: -5 beyond 5 sd; x1.4: nothing.
inline constexpr double kTagMaxMovePx = 2;

// Prior standard deviation of the logarithm of the spread about kUsualSpreadPx: 0.5 to 1.4 px.
// Source: x0.7: errors +0.1 %; x1.4: nothing.
inline constexpr double kEdgeLogBlurSd = 0.5;
// Prior standard deviation of the two grey levels, as a share of their difference. Source: x0.7:
// errors -0.6 %; x1.4: errors +0.4 %.
inline constexpr double kEdgeLevelSdShare = 0.3;
// The prior standard deviations of the bends of a side, as a share of those of a whole tag
// (kTagBendSd, kTagTwistSd): a side by itself does not average them. Source: x0.7: nothing;
// x1.4: errors +0.2 %.
inline constexpr double kEdgeBendShare = 0.1;

// ---- Fitting a tag's pattern: the whole tag (refine_tag)

// px around a tag that are fitted, and px of each side next to the corner if corners are fitted
// by themselves. Source: kTagOutsidePx, x0.7: errors +1.2 %, squares over claims -1.1 %; x1.4:
// errors -0.4 %, squares over claims +0.5 %. kTagInsidePx, x0.7: corners +0.2 %, errors +4.8 %,
// squares over claims -8.2 %, -31 beyond 5 sd; x1.4: errors -1.2 %, squares over claims +7.8 %.
inline constexpr double kTagOutsidePx = 16;
inline constexpr double kTagInsidePx = 40;

// Spreads (blur and pixel together) from a pixel to what is not known, or to the next side of a
// side's pixels, at least: its influence is the normal integral beyond 3, 0.14 %.
inline constexpr double kTagUnknownReach = 3;

// Prior standard deviation of the shift of borders, px, each of ink and of bloom. Source: ink
// spreads by up to about 0.15 px (docs/trust/corners.md).
inline constexpr double kTagShiftSdPx = 0.1;

// Prior standard deviation of the curvature that a lens gives to a line, in 1 / (longer side of
// the picture), and of its change along the line, in 1 / side^2. Source: a fisheye whose picture
// spans 190 degrees has a focal length of 0.3 sides and lines of curvature up to 0.6 / f, which
// is 2 / side. The second: a curvature that changes by its own size within a tenth of the side.
// Source: x0.7: squares over claims +1.6 %; x1.4: corners -0.6 %, errors +0.7 %, squares over
// claims -0.5 %, -62 beyond 5 sd.
inline constexpr double kTagBendSd = 2;
inline constexpr double kTagTwistSd = 10 * kTagBendSd;
// px. Smaller pictures are taken for parts of one with this side (docs/trust/corners.md). Source:
// the smallest usual picture, QVGA.
inline constexpr double kTagSmallestPicturePx = 320;

// Squared, in prior standard deviations: mean over the four bends of second, or the eight of
// third order, beyond which larger bends are expected; and the factor by which these priors then
// widen, for each order. `corner_accuracy lens`: NEES of tags under
// a barrel of k1 = -0.4 fell from 1.83, 1.29, 1.42 (30, 40, 100 px) to 1.04, 0.94, 1.12. Source:
// kTagStrongBends, x0.7: errors +0.1 %; x1.4: errors -0.1 %. kTagStrongerBends, x0.7: errors
// +0.1 %, squares over claims +0.6 %, +10 beyond 5 sd; x1.4: errors +0.3 %, squares over claims
// +0.3 %.
inline constexpr double kTagStrongBends = 0.5;
inline constexpr double kTagStrongerBends = 2;

// px. A longer tag under an unknown lens is fitted corner by corner: a lens bends it beyond
// third order. Source: x0.7: squares over claims -1.7 %; x1.4: nothing.
inline constexpr double kTagMaxWholePx = 110;
// A shorter tag is fitted corner by corner if bends of third order move a corner by this many of
// its standard deviations. Source: x0.7: errors +0.8 %; x1.4: nothing.
inline constexpr double kTagThirdOrderSds = 8;
// Standard deviation that bends beyond third order add to the corners of a large tag fitted as a
// whole, as a share of what bends of third order do to them. Source: x0.7: squares over claims
// +0.4 %; x1.4: squares over claims -0.4 %.
inline constexpr double kTagNextOrderShare = 0.25;

// Standard deviations of the start's homography as a prior, over a region of size 1: of places,
// scales and turns, and of the perspective. Two lines around one corner do not determine the
// last three. Under wider priors 7 of 60 fisheye tags of 160 and 250 px did not converge
// (`corner_accuracy lens`). Source: kTagScaleSd, x0.7:
// errors -0.6 %, squares over claims -0.6 %; x1.4: errors +0.1 %, squares over claims +0.3 %.
// kTagPerspectiveSd, x0.7: nothing; x1.4: errors +0.1 %, squares over claims +0.4 %.
inline constexpr double kTagScaleSd = 0.05;
inline constexpr double kTagPerspectiveSd = 0.03;
// Ratio of the residuals' variances, region over last window, beyond which the region shows
// something else and the window is the answer: without it the errors of checkerboards grow by
// 1.6 %. Source: x0.7: corners -0.2 %, errors +0.1 %, -38 beyond 5 sd; x1.4: corners +0.1 %,
// errors +0.2 %, squares over claims +0.3 %, +5 beyond 5 sd.
inline constexpr double kTagMaxVarianceGrowth = 1.7;
// Noise over contrast of a fit, at most; beyond, the picture does not show this pattern. Source:
// 0.21 finds tags in noise of 40 levels, whose claims hold, but also corners that are half hidden
// (explain_test). x0.7: corners -0.4 %, -12 beyond 5 sd.
inline constexpr double kTagMaxNoiseShare = 0.15;

// Twice the log-likelihood ratio by which a shade of second order, and slopes of black and of the
// spread, must be seen in the residuals. Source: chi-square with seven degrees of freedom,
// p = 0.001.
inline constexpr double kLightSure = 24.3;

// Standard deviations that are subtracted from the factor by which residuals that are correlated,
// or larger at borders, make covariances grow. Source: of independent residuals one factor in six
// then exceeds 1, all together by 0.08 standard deviations, of 0.05 to 0.15.
inline constexpr double kNoiseSureSds = 1;

// ---- Fitting a tag's pattern: gamma, sharpening and print of a picture

// Number of tags from which gamma is estimated. Source: x0.7: errors +0.4 %, -6 beyond 5 sd;
// x1.4: errors -0.1 %.
inline constexpr std::size_t kTagGammaTags = 2;
// Bounds of the logarithm of gamma (0.3 and 1.4). Source: cameras have 0.45 to 1.
inline constexpr double kTagMinLogGamma = -1.2;
inline constexpr double kTagMaxLogGamma = 0.35;
// Twice the log-likelihood ratio by which another gamma must beat 1 (chi-square of one degree of
// freedom: 4e-8). Source: x0.7: errors -0.3 %, squares over claims -0.6 %; x1.4: errors +0.2 %,
// squares over claims +0.3 %.
inline constexpr double kTagGammaSure = 30;
// Bounds of unsharp masking: its amount, and the standard deviation of its Gaussian, px. Source:
// none; chosen by hand, about twice what the pictures of docs/trust/worlds.md have.
inline constexpr double kSharpenMaxAmount = 3;
inline constexpr double kSharpenMinRadiusPx = 0.5;
inline constexpr double kSharpenMaxRadiusPx = 3;
// Twice the log-likelihood ratio by which sharpening must beat none. Source: chi-square, p = 3e-7.
inline constexpr double kSharpenSure = 30;
// Noise over contrast of a fit, from which on it may be strong overshoot, which a weak sharpening
// does not lessen. Source: an amount of 1.5 with a radius of 2 px leaves 0.12 of it after a blur of
// 1.4 px; where there is less, a weak one lessens it, too.
inline constexpr double kSharpenNoisyShare = 0.05;
// Twice the log-likelihood ratio by which lines between cells must beat equal cells: seven lines
// and the thousand drawings that are tried reach 60 in one of 1e7 pictures of exact prints, but 86
// was seen in one of 30 pictures of a webcam, whose pixels are not as the model has them.
inline constexpr double kPrintSure = 100;
// The same by which free lines must beat those of the best drawing, as that of seven lines.
inline constexpr double kPrintIsDrawing = 45;

// ---- Completing boards

// Pixels of the smallest halved picture that is searched. Source: x0.7: nothing; x1.4: errors
// -0.5 %.
inline constexpr double kBoardMinHalvedPixels = 150'000;

// Tags nearest to a missing one from which its place is predicted. Source: x0.7: nothing; x1.4:
// -7 beyond 5 sd.
inline constexpr std::size_t kBoardNeighbours = 4;
// Cells by which a prediction may be off. Source: x0.7 and x1.4: nothing.
inline constexpr double kBoardReachCells = 2;
// Least correlation with its pattern at which the corners of a refined tag are kept without a
// search for a higher one. Source: x0.7: nothing; x1.4, a search for each: corners -0.1 %, -11
// beyond 5 sd.
inline constexpr double kBoardSureCorrelation = 0.93;
// px. Refined corners are wrong if they lie farther from the quad of highest correlation (the
// search is no finer), and farther than kMaxMoveShare of a cell, and correlate less. Source:
// x0.7: corners -0.4 %, errors +0.3 %, squares over claims +0.2 %, -11 beyond 5 sd; x1.4:
// nothing.
inline constexpr double kBoardWrongCornerPx = 1;
// Probability that random bits in a frame are taken for a tag that no other confirms: at most, and
// where other tags of its plane should be in the picture and are not. Source: chosen by hand with
// the study `detect_answers` (without them every eleventh picture without tags showed one of
// tag16h5).
inline constexpr double kBoardMaxChance = 5e-4;
inline constexpr double kBoardMaxChanceIfRefuted = 1e-5;

// ---- The lens of a picture, from the tags of one panel

// Corners that determine lens and pose: twice as many equations (48) as the 14 parameters, and some
// of them may be wrong.
inline constexpr std::size_t kPanelMinCorners = 24;
// Prior standard deviations: of the logarithm of the focal length (about half the longer side of
// the picture), of the logarithm of fy / fx, of the principal point (in longer sides), and of k1
// to k4 (a perspective's are 0.33 and less). Source: kPanelLogFocalSd, x0.7 and x1.4: nothing.
// kPanelLogAspectSd, x0.7 and x1.4: nothing. kPanelCentreSd, x0.7 and x1.4: nothing.
// kPanelTermSd, x0.7: nothing; x1.4: errors +0.1 %, squares over claims +0.2 %.
inline constexpr double kPanelLogFocalSd = 1;
inline constexpr double kPanelLogAspectSd = 0.01;
inline constexpr double kPanelCentreSd = 0.05;
inline constexpr double kPanelTermSd = 0.5;
// Spreads beyond which weights fall (Cauchy's robust cost), and the largest spread of a
// checkerboard's corners, in their standard deviations, up to which they are fitted under the
// lens. Source: x0.7: nothing; x1.4: errors +0.2 %, squares over claims +0.7 %, +38 beyond 5 sd.
inline constexpr double kPanelTailSpreads = 3;

// A lens is tried if straight lines leave at most this of a tag unexplained (one less its
// correlation with its pattern), and taken if it leaves at most that share of it. Source: in
// `near_grids` straight lines leave 0.06 and less, of what is read by chance in noise 0.3 to 0.8; a
// lens leaves 0.5 of that and less, mostly 0.1, and 0.97 of tags that are not bent.
inline constexpr double kBentMostUnexplained = 0.3;
inline constexpr double kBentUnexplainedShare = 0.6;

// ---- Explaining, and the warning of a wrong border

// A picture shows another kind of tags (family, border, mirrored, inverted) if it has this many
// times the tags of the target's kind, and this many if it has none of these: a single tag may be
// read by chance. Source: none; chosen by hand.
inline constexpr int kOtherTagsRatio = 2;
// Tags, and corners along each side of a grid, by which a picture that shows nothing of the target
// shows a target of another type. Small families are read by chance, and the frames of tags are
// grids of 2 x 4 and less. Sensitivity, over 103 pictures of seven kinds with target files of four
// types: 3 and 6 tags give the same answers; a grid of 2 takes 12 of 12 grids of circles for
// checkerboards, 3 one of them, 4 none.
inline constexpr std::size_t kTagsOfOtherTarget = 4;
inline constexpr int kGridOfOtherTarget = 3;
// Sides of a tag. Two spacings of a board that differ by more are different ones. Source: usual
// spacings, 0.2, 0.25 and 0.3, differ by 0.05.
inline constexpr double kSpacingTolerance = 0.04;
// Neighbouring tags at their places on the board, in its pitch (squares of a ChArUco board): how
// far off they may be, and how many pairs are needed. Source: none; chosen by hand, between the
// perspective within a few tags and half a pitch.
inline constexpr double kLayoutTolerance = 0.3;
inline constexpr std::size_t kFewestLayoutPairs = 8;
// The target file's layout is wrong if more of the pairs than this agree with another one, and as
// many more than with it as this lacks to all. Source: none; chosen by hand: of a row of 13 squares
// a shifted pattern moves the markers at the ends, which are in an eighth of the pairs.
inline constexpr double kLayoutSureShare = 0.9;
// Squares. Two sizes of markers that differ by more are different ones. Source: usual sizes, 0.6,
// 0.7, 0.75 and 0.8, differ by 0.05.
inline constexpr double kMarkerShareTolerance = 0.04;
// A picture is looked at for mistakes in the target file if it shows a smaller share of a board's
// points. Source: none; chosen by hand. More cost time only.
inline constexpr double kSuspiciousShare = 0.9;
// Share of a board's points before a row that a picture must show, and of the row that must be
// inside of it, to have room for this row; and number of pictures with room but without the row
// that show a board of fewer rows. The number is said with an "if". Sensitivity: with 2 pictures
// the boards of explain_test are named alike, with 4 none of which there are 3. Source of the
// shares: none; chosen by hand.
inline constexpr double kShownShare = 0.5;
inline constexpr std::size_t kPicturesWithRoom = 3;

// ---- Finding checkerboards

// px. Radii of the circles that are tried: 3 for squares of 10 px seen at 60 degrees, 5 and 8
// for noise and blur (`checker_accuracy found`). Source: x0.7: corners -0.5 %, errors -0.1 %,
// squares over claims -0.2 %, -54 beyond 5 sd; x1.4: nothing.
inline constexpr std::array<double, 3> kJunctionRadiiPx = {5, 3, 8};
// Radians. Largest bend of a line at a junction and turn to the next one, and so the least angle
// between two lines. Source: x0.7: nothing; x1.4: corners -4.2 %, errors +0.7 %, squares over
// claims +1.9 %, -460 beyond 5 sd.
inline constexpr double kMaxTurn = 0.45;
// Share of the distance to the next junction by which a prediction, also of a corner before its
// fit, may be off. Source: from a half on two predictions claim
// one junction; two thirds of that. x0.7: nothing; x1.4: corners +0.1 %.
inline constexpr double kMaxMoveShare = 1.0 / 3;
// Share of a grid's outermost line that must be seen (of the fullest line) and fitted (of the
// board's line): with fewer the line is not the board's. Source: x0.7: corners -0.5 %, errors
// +0.1 %, -54 beyond 5 sd; x1.4: nothing.
inline constexpr double kMinLineShare = 0.3;
// Squares of a grid that must have all four corners: more than this share of those within it, or
// more than this number. Source: 160 pictures of noise, blocks and print have up to 6 in sparser
// grids that pass the tests below; rendered boards have 0.67 of theirs and more, boards partly
// hidden 9 and more.
inline constexpr double kMinSquaresShare = 0.5;
inline constexpr double kEnoughSquares = 8;
// Share of the contrast of neighbouring squares by which squares of one colour may differ, on
// average. Source: noise of kTagMaxNoiseShare makes 0.17 of it; rendered and real boards have up to
// 0.13, the tags and small squares of an AprilGrid 0.25 to 0.4.
inline constexpr double kMaxLikeSquaresShare = 0.25;
// The same of a square's middle and the places halfway to its corners. Source: squares of 5 px,
// blurred by 1.5 px, have 0.28 of it, two crossed sines 0.5.
inline constexpr double kMaxWithinSquareShare = 1.0 / 3;
// Squares beyond the next junction that are fitted with a corner: pixels before them are then
// known. Source: 3 spreads of 0.9 px for squares of 10 px.
inline constexpr double kCheckerBeyond = 0.3;
// Part of the outermost squares that is printed for sure: half a square. Source: x0.7: corners
// +0.1 %, errors +0.3 %, squares over claims +0.8 %; x1.4: corners -0.2 %, errors +0.2 %,
// squares over claims -1.0 %, -51 beyond 5 sd.
inline constexpr double kCheckerOutside = 0.5;

// ---- Finding grids of circles

// OpenCV's search for dark blobs: shares of the pixels below the lowest and above the highest
// threshold, number of thresholds, px between two blobs, px^2 of a blob, and its area over that of
// its hull, all at least. Source: OpenCV's defaults are for levels from 50 to 220, discs 10 px
// apart and of less than 5000 px^2; discs of 5 px have 20 px^2, and on pixels a convexity of 0.8.
inline constexpr double kBlobTailShare = 0.01;
inline constexpr int kBlobThresholds = 12;
inline constexpr float kBlobMinDistancePx = 5;
inline constexpr float kBlobMinAreaPx2 = 16;
inline constexpr float kBlobMinConvexity = 0.8F;
// Ratio of the diameters of two discs beside one another in a grid, at most. Source: that of their
// distances from the camera, 1.3 if they are nearer than three spacings, and a pixel of 5.
inline constexpr double kBlobMostRatio = 1.5;
// A lattice of so many discs is a grid however it is bent: that many scattered discs seldom lie
// where a lattice predicts its next ones, a third of a step off. Source: x0.7: 5 x 4 grids in 14 of
// 60 pictures of scattered discs instead of 6; x1.4: in 2. Without it no 8 x 6 grid is found four
// spacings before a fisheye (74 of 90 pictures).
inline constexpr std::size_t kManyDiscs = 16;
// Standard deviation of fewer discs from a perspective image of their grid, in its spacings, at
// most. Source: x0.7: 16 of 360 rendered 4 x 3 grids before fisheyes are not found; x1.4: grids of
// 4 x 3 and of 3 x 3 in 17 of 60 pictures of scattered discs each, instead of 1 and 2.
inline constexpr double kMaxDiscStrain = 0.07;

// Centres by which the image of the board about a disc is predicted: the disc and its neighbours in
// a square.
inline constexpr std::size_t kCircleNeighbours = 9;

}  // namespace tagcal::internal::policy
