#pragma once

#include <cstddef>

// Every number that decides an answer, a status or a finding of the estimators, once: what it
// means, its unit, and its source (a paper, a probability, or the study that measured it). A test
// refuses others elsewhere in `estimate`, but for rounding, sizes and limits of work, whose lines
// say `// numeric:`. Those chosen by hand have a row in docs/trust/sensitivity.md: how many answers
// change if they are multiplied by 0.7 and by 1.4.

namespace tagcal::internal::policy {

// ---- Probabilities, as quantiles of the normal distribution (one-sided)

// p = 0.001: correlated residuals, a pose's largest residual by their median, the halves of a
// calibration, and by how much weak perspective must fit worse than a focal length.
inline constexpr double kQuantile1e3 = 3.09;
// p = 0.0001: what a check of a calibration calls significant, the chi-square of a pose's residuals
// that contradicts a stated or assumed noise, the F ratio of a tag off its place, and the readout
// of a film that is taken out of its corners.
inline constexpr double kSignificant = 3.72;

// ---- Noise

// A residual longer than this many standard deviations is an outlier, and so is a tag of the target
// whose shift is this many times that of the median tag. By a normal distribution one coordinate in
// 1.7 million exceeds it.
inline constexpr double kOutlierSigmas = 5;
// px. The floor of a standard deviation, and of a bias of the residuals (RMS), also by the size of
// the tags: below it the digits of a file decide, not noise (files hold pixels with 2 to 6 digits
// after the point).
inline constexpr double kLeastSigmaPx = 0.01;
// px. The noise of a good corner: a smaller displacement of rows is no finding, and a lens within
// it stands for another one (docs/reference/models.md has differences of usual lenses). Chosen by
// hand. For the lens x 0.7 and x 1.4 change no answer of docs/trust/sensitivity.md.
inline constexpr double kGoodCornerPx = 0.1;
// Degrees of freedom from which residuals estimate a noise that is not stated: the standard
// deviation of that estimate is 1 / sqrt(2 * 50) = 10 %. With fewer, kAssumedSigmaPx is assumed,
// and a finding says so (docs/reference/conventions.md).
inline constexpr int kEnoughDegreesOfFreedom = 50;
// px. Chosen by hand.
inline constexpr double kAssumedSigmaPx = 0.5;

// ---- What the data determine

// sd(f) / f above which a focal length is refused (the design's rule: docs/trust/how_sure.md).
inline constexpr double kFocalRefused = 0.10;
// Standard deviation of the projection at infinity, over half the diagonal of the image, from which
// a model is refused. Chosen by hand (study focal_refusal counts what it lets pass).
inline constexpr double kProjectionRefused = 0.02;
// px. A finding names a combination of parameters that moves the projection at infinity by more
// than this, in one standard deviation. Chosen by hand.
inline constexpr double kProjectionWeakPx = 2;
// Degrees of freedom below which the status of a calibration is degenerate, and without a tag of a
// view no test shows that the tag is off its place: with 10 the residuals estimate their noise to
// 1 / sqrt(2 * 10) = 22 %. Chosen by hand.
inline constexpr int kFewestDegreesOfFreedom = 10;

// ---- Rigs (rig/)

// RMS by which a rig moves a camera's corners beyond what noise does, over their noise, from which
// it is warned of. Source: the 420 cameras of 110 right rigs of `tagcal-study rigs` have 0.10 at
// most, real synchronous pairs 0.23; cameras whose nearly equal lenses are exchanged have 0.7.
inline constexpr double kStrained = 0.5;

// s. Between instants further apart the motion of the board is not interpolated, and by instants
// further apart than the second number no offset of a clock is told: a board in the hand turns back
// within a few tenths of a second. Chosen by hand.
inline constexpr double kLongestGap = 0.2;
inline constexpr double kOffsetGap = 0.1;

// ---- Poses of single views (pose/)

// Costs are sums of squared whitened residuals, in sigma^2 where the text says so: then the
// difference of two costs is a chi-square.

// A pose whose cost exceeds the least one by more sigma^2 than this is excluded (5 standard
// deviations). So is a calibration from which a Gauss-Newton step would lower the cost by more:
// correlated coefficients reach 5, a solver that stopped at the fold of a lens hundreds (study
// focal_refusal).
inline constexpr double kExcludedCost = 25;
// sigma^2. A second minimum whose cost exceeds the least one by less makes the pose ambiguous. If
// the images of two poses are d sigma apart, the wrong one is better by T sigma^2 with the
// probability Q((d^2 + T) / 2 d), at most Q(sqrt T): 3e-5 for T = 16. (With T = 9 it is 1.3e-3, as
// map tag-tilt-distance measured.)
// It is also the chi-square by which the other kind of lens must explain the corners better than
// the one that was asked for.
inline constexpr double kAmbiguousCost = 16;

// Pose with focal length.
// sd(f) / f up to which neither the likelihood towards shorter focal lengths nor weak perspective
// is tested. Of 13,000 views up to 3 %, at tilts of 0 to 25 degrees, weak perspective explained
// none as well; of 4,500 up to 5 % two.
inline constexpr double kFocalWellKnown = 0.03;

// Points nearly on a line: RMS width over length below which the turn about the line is tested, and
// the turn that must be excluded by kExcludedCost, seven times the 0.05 rad up to which the maps
// count a rotation as known. Chosen by hand, checked by map line.
inline constexpr double kNarrowWidth = 0.25;
inline constexpr double kLineTurnRad = 0.35;

// The profile of a pose (pose_hypotheses.hpp): standard deviations of its first step, and sigma^2
// at which it ends. Chosen by hand, checked by maps points, line, tag-tilt-distance and
// focal-tilt-noise (fewer than 1 in 1,000 poses are wrong and called ok).
inline constexpr double kProfileSigmas = 5;
inline constexpr double kProfileEnd = 9;

// Starts (initial_poses.hpp).
// Smallest over largest of a quadrangle's four triangles (a square: 1) up to which its homography
// is too sensitive to noise, and P3P gives starts as well. Chosen by hand, checked by
// map points.
inline constexpr double kPoorQuadrangle = 0.5;
// Thickness over size below which pose with focal length also starts from a plane. Source: chosen
// by hand, checked by map flatness.
inline constexpr double kPlaneStartThickness = 0.3;
// px. RMS above which a closed form's pose with focal length may lead to a wrong minimum: weak
// perspective gives a start as well. Chosen by hand.
inline constexpr double kPoorStartRmsPx = 2;

// The test of the residuals (residual_test.hpp).
// Points from which the largest residual is compared with the median of all. Chosen
// by hand.
inline constexpr std::size_t kEnoughForMedian = 6;
// RMS of the residuals over the RMS size of the target's image, above which noise that is not
// stated is no noise. Chosen by hand.
inline constexpr double kLargestNoiseOfImage = 0.05;

// RANSAC (ransac.hpp, pose_ransac.hpp).
// Standard deviations of an inlier's residual: the length of one in 3,000 exceeds them.
inline constexpr double kInlierSigmas = 4;
// px. Noise that the search takes where none is stated. Chosen by hand.
inline constexpr double kRansacSigmaPx = 1;
// Probability that a better consensus was missed, and largest number of false alarms of one (Moisan
// & Stival, IJCV 2004). Chosen by hand.
inline constexpr double kWrongConsensus = 1e-4;
// Inlier tolerances within which the density of wrong corners is counted. Chosen by hand,
// checked by map swapped.
inline constexpr double kDensityTolerances = 10;
// A second pose with this share of the inliers of the first makes both no answer; up to half of the
// first one's inliers may be among them. Chosen by hand, checked by map swapped.
inline constexpr double kRivalShare = 0.8;

// ---- Priors of a calibration (bundle/lens_prior.hpp, bundle/bundle_adjustment.hpp)

// Standard deviations of what is known before any picture. Those of distortion stand beside the
// parameters of each lens (camera/lens.hpp).
// Radius of the image's corner, over the focal length, towards which that of wider lenses tends.
inline constexpr double kPriorLargestRadius = 1.5;
// Logarithm of the focal length about this many widths of the image: 13 to 128 degrees of view
// within two of them.
inline constexpr double kPriorFocal = 0.8;
inline constexpr double kPriorLogFocal = 0.7;
// log fy / fx, and the principal point about the centre over the width of the image.
inline constexpr double kPriorAspect = 0.005;
inline constexpr double kPriorCentre = 0.02;
// Degrees of freedom of Student's t of the priors of lens and board: some lenses are unlike most,
// and some boards are not what their file says.
inline constexpr double kPriorFreedom = 4;
// A board of each material, in the order of Material (paper on a plate, a printed plate of
// aluminium or its composite, chromium on glass or ceramic): bend and twist over its diagonal, and
// the share by which its print is longer along y than along x. Paper: twice the bend of EuRoC's
// board (0.9 mm of 930: docs/trust/real_corners.md), whose make is not published. Source of the
// others: none that states flatness; chosen by hand. Aluminium: Calib.io ("Calibration target
// substrates") sells its composite as stiff and flat, but wants 6 mm, and a frame beyond 800 x 600
// mm: half a millimetre in a metre. Glass: ten times flatter, still far from the micrometres of an
// optical surface. Print: CalibVision ("What is a camera calibration target?") states 1 um for
// glass and 5 um for composite, NPL 0.8 um for its grid plates of 250 to 650 mm: these are at least
// ten times wider, for heat and sheets that are not measured.
inline constexpr double kPriorFlatness[] = {0.002, 0.0005, 0.00005};
inline constexpr double kPriorPrint[] = {0.002, 0.0005, 0.0001};
// Row terms (px a row) among which the data choose; the largest, a rolling shutter, for fewer than
// kFewestTellingViews views.
inline constexpr double kRowSigmas[] = {0.0003, 0.001, 0.004};

// ---- Bundle adjustment, covariance, projection (bundle/, advice)

// Share of the image's diagonal by which a board moves (RMS) between two poses. Chosen by hand:
// halves of three films of EuRoC differ by 1.51 times their claims without poses, and
// by 1.40, 1.35, 1.29 and 1.39 with 0.011, 0.034, 0.067 and 0.112, each before design_effect;
// by 1.24 with it.
inline constexpr double kSamePose = 0.05;

// Views that the assumed overdispersion, and the scaled covariance beside the spread of the views,
// weigh as much as (covariance.hpp).
inline constexpr double kOverdispersionViews = 6;
inline constexpr double kSpreadViews = 40;
// The overdispersion that is assumed for uncorrelated residuals, and what a correlation of
// neighbouring residuals adds, per unit.
inline constexpr double kLeastOverdispersion = 1.2;
inline constexpr double kOverdispersionByCorrelation = 20;

// The profile likelihood of a calibration (covariance.hpp).
// Standard deviation over the focal length up to which a linear covariance is trusted. Chosen by
// hand (study calibration_nees confirms that covariance).
inline constexpr double kLinearShare = 0.01;
// Standard deviations of the profile on either side. Chosen by hand (map
// calibrate-parallel has what it leads to).
inline constexpr double kProfileBundleSigmas = 2;

// The advised view (advice.cpp). Of views that leave at most this many times the least variance,
// the one that fills most gaps. Chosen by hand (docs/trust/how_sure.md).
inline constexpr double kNearlyLeastVariance = 2;

// ---- Calibration: start, rejection, choice of the model (calibration/)

// A share of a count, as a fraction of whole numbers: comparisons with it are exact.
struct Share {
  int part = 1;
  int whole = 1;

  constexpr double value() const { return static_cast<double>(part) / whole; }
};

template <typename Count>
constexpr bool is_below(Count count, Share share, Count all) {
  return static_cast<Count>(share.whole) * count < static_cast<Count>(share.part) * all;
}

template <typename Count>
constexpr bool is_above(Count count, Share share, Count all) {
  return static_cast<Count>(share.whole) * count > static_cast<Count>(share.part) * all;
}

// Corners of one board that a view needs: a homography has 8 degrees of freedom.
inline constexpr std::size_t kLeastViewCorners = 4;
// At least this share of the complete tags of a view turn the wrong way: the view is mirrored.
// Chosen by hand (tests/estimate/robust_calibration_test.cpp has both kinds).
inline constexpr Share kMirroredTags{4, 5};
// More corners outside of the image say that its size is wrong: of pictures of twice that size
// three quarters are outside. Chosen by hand.
inline constexpr Share kMostOutsideImage{1, 20};

// Focal length that stands for an unknown one, over the longer side of the image: 53 degrees of
// view, or 143 of a fisheye. Chosen by hand.
inline constexpr double kNominalFocal = 1.0;
inline constexpr double kNominalFisheyeFocal = 0.4;

// Least median of squares (projective_lmeds.hpp). A ray is an inlier within kLmedsSigmas robust
// standard deviations plus kLmedsLensRad (rad), which allows for the distortion within a view.
// Chosen by hand.
inline constexpr double kLmedsSigmas = 6;
inline constexpr double kLmedsLensRad = 1e-3;
// The share of inliers ends the search if the median angle is below this (rad). Chosen by hand, to
// save time on good data.
inline constexpr double kLmedsGoodMedianRad = 0.01;

// A weak view is plausible if its squared residuals are below this share of the squared extent of
// its corners: 0.2^2, a fifth of their extent. Chosen by hand, against random pixels
// (tests/estimate/weak_calibration_test.cpp).
inline constexpr double kWeakResidualShare = 0.04;

// A minority: of views or tags that are outlying, so that the model or the target is not to blame,
// and of rejected corners: of a board that stands still where another one moved, and of a view
// above the median share, from which on the view is outlying. x 0.7 and x 1.4 change no world
// (docs/trust/sensitivity.md).
inline constexpr Share kMinority{1, 3};
// Number of views from which a median of them shows which one is outlying, and their spread shows
// how large the row terms are. Chosen by hand. Times 1.4 changes 0.5 % of the
// worlds (docs/trust/sensitivity.md).
inline constexpr int kFewestTellingViews = 4;

// Share by which a noise may differ from another one that stands for it: the noise that weighed the
// priors of a fit, and that of the corners' covariances if lens and target add to it. x 0.7 and x
// 1.4 change 3.5 % of the worlds and up to 5 % of the halves by 1 % (docs/trust/sensitivity.md).
inline constexpr double kNoiseChange = 0.1;

// Fits are compared by their noise if each has at least this share of the other's inliers; with
// fewer of all corners a finding gives the share that was rejected. Chosen by hand.
inline constexpr Share kComparableInliers{9, 10};
// Views on which kinds of lens are compared, evenly spread: a limit of work. Chosen by hand,
// checked by study model_confusion.
inline constexpr std::size_t kChoiceViews = 20;
// Parameters by which BIC is raised for a fisheye against a polynomial: where both describe the
// same images, the ordinary lens is meant. Source: study model_confusion (docs/trust/how_sure.md).
inline constexpr int kFisheyeCharge = 3;
// Chi-square by which each parameter lowers the weight of a component: the prior odds of a term
// whose size may be anything from nothing to its prior's width. 2 is Akaike's.
inline constexpr double kComponentPenalty = 2;
// Standard deviations of the claim by which the answer may differ from the posterior's mean. With
// one the model that made the data would be refused by chance in a third of all sets.
inline constexpr double kAgreeingSigmas = 3;
// Divides the log odds of two kinds of lens. Source: study halves (with 1, the odds of EuRoC's
// lenses change sides between halves of the views, and claims are 1.7 times too small).
inline constexpr double kKindTemper = 4;
// Weights below this are dropped: they are less than the claim's own accuracy.
inline constexpr double kLeastModelWeight = 0.01;

// Share of the sum of squares that opencv5 would explain, above which a wrong target is not blamed.
// Chosen by hand (docs/trust/real_corners.md has right and wrong targets).
inline constexpr double kLargerLensShare = 0.1;

// ---- Checks of a calibration (checks/)

// Share of a prior's standard deviation above which a coefficient is hardly known from the data:
// half of its variance would be the prior's.
inline constexpr double kLikePrior = 0.7;
// Factor by which a standard deviation is much larger: the residuals beyond the stated noise, the
// correlated ones of an outlying view beyond the median view's, or a result without an untested
// assumption of its model (docs/trust/how_sure.md). Chosen by hand.
inline constexpr double kMuchLargerSd = 1.5;

// Share of a board's diagonal by which no board bends (docs/trust/how_sure.md). In
// docs/trust/real_corners.md a model that is too small fits a bend of 15 mm to a flat board.
inline constexpr double kLargestBoardBend = 0.01;
// Fewest views of a comparison: of a half, of the errors of a target and of its corners. What fewer
// views share, as a bend of the board, may look like the lens. Chosen by hand.
inline constexpr int kFewestComparedViews = 3;

// The halves disagree if their difference exceeds this many of its standard deviations and the
// chi-square of the parameters is beyond p = 0.001 (after mrcal's cross-validation;
// docs/trust/how_sure.md, study `warnings`).
inline constexpr double kHalvesDisagree = 2;

// Standard deviation of the projection at the corners of the image, over its diagonal, above which
// the lens is extrapolated there (docs/trust/how_sure.md, map calibrate-extrapolation).
inline constexpr double kImageCornerShare = 0.005;

// Errors of the target (checks/target_error.hpp, docs/trust/how_sure.md).
// The target is wrong if shifts explain this share of the squared residuals (boards of paper: 0.25
// to 0.33) and this much in px RMS (boards of paper: 0.10 to 0.12; docs/trust/real_corners.md).
inline constexpr double kTargetShareFound = 0.2;
inline constexpr double kTargetShiftFoundPx = 0.125;
// The answer is refused if they explain this share, and twice kTargetShiftFoundPx. One shift must
// explain as much of a rejected corner to count as the target's error. Chosen by
// hand.
inline constexpr double kMostOfResiduals = 0.5;
// It is refused, too, if the outlying tags are no minority.
// Share of a tag's size that ink or light may add: with more than a cell of ten on either side the
// pattern cannot be read.
inline constexpr double kLargestTagScale = 0.2;

// ---- Fits between models of lenses (lens_fit.hpp)

// Cosine of the angle to the axis, 80 degrees, up to which a perspective lens can see a corner.
// Chosen by hand.
inline constexpr double kPerspectiveCosine = 0.17;

}  // namespace tagcal::internal::policy
