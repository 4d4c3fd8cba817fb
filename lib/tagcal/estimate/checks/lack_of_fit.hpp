#pragma once

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/bundle/residual_bias.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// Evidence that the residuals of a solved bundle do not fit the model.
struct LackOfFit {
  const Bundle* bundle = nullptr;
  const BundleInformation* information = nullptr;  // with the bends of `board`; may be null
  const FlatBoard* board = nullptr;                // null: none, or several
  bool small_model = false;                        // a larger model explains the residuals better
  bool bent = false;  // the residuals show a bend that options.board_warp did not ask for
  ResidualBias field;
  std::optional<HalvesCheck> halves;

  // Factor of all variances for residuals that are not independent: the larger one of the residual
  // bias and of the split-half check.
  double inflation() const;
};

// The noise that the checks use, at least policy::kLeastSigmaPx: below it the rounding of a file
// would count as lack of fit.
double sigma_with_floor(const Calibration& c, const CalibrateOptions& options);

// First tests the model: it is too small if opencv5 would lower the sum of squares (to first order)
// by more than chance and by more than a bent board does. Then tests the board: with
// options.board_warp the bend is part of the answer, else a significant bend is a warning.
void judge_model_and_board(Calibration& c, LackOfFit& evidence, const CalibrateOptions& options);

// Fills in the residual bias over the image and the split-half check.
void compare_residuals(const Calibration& c, LackOfFit& evidence, const CalibrateOptions& options);

// Adds the effect of a free bend to the covariance of a flat board that the residuals contradict
// (evidence.bent): the variance of the bend and the square of its estimate.
void add_bend(BundleCovariance& covariance, const LackOfFit& evidence, double sigma);

// Warns of biased residuals, and of halves of the views that disagree.
void warn_of_lack_of_fit(Calibration& c, const LackOfFit& evidence);

// Warns of a bend beyond policy::kLargestBoardBend, and returns true then.
bool warn_of_impossible_bend(Calibration& c, const BoardWarp& warp, const FlatBoard& board);

}  // namespace tagcal::internal
