#pragma once

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/bundle/residual_bias.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// What the residuals of a solved bundle can be held against, and what they say.
struct MisfitEvidence {
  const Bundle* bundle = nullptr;
  const BundleInformation* information = nullptr;  // with the bends of `board`; null: none
  const FlatBoard* board = nullptr;                // null: none, or several
  bool small_model = false;                        // said already
  bool bent = false;                               // a bend that was not asked for, and was said
  ResidualField field;
  std::optional<HalvesCheck> halves;

  // By which all variances grow where residuals are not independent: the larger of those that the
  // places and the halves ask for.
  double inflation() const;
};

// For what doubts the answer: digits in a file, below the least noise that there is, are no error.
double sigma_that_counts(const Calibration& c, const CalibrateOptions& options);

// A model asked for by name that is too small comes first, where opencv5 would lower the sum of
// squares (to first order) by more than chance and by more than a bent board does. Then the bend:
// part of the answer where it was asked for, else a warning where the corners show it.
void judge_model_and_board(Calibration& c, MisfitEvidence& evidence,
                           const CalibrateOptions& options);

// Holds the residuals against one another: from place to place, and half of the views against half.
void compare_residuals(const Calibration& c, MisfitEvidence& evidence,
                       const CalibrateOptions& options);

// The covariance where the board is let be bent, with the square of what that changes: of an answer
// on a flat board that the corners contradict (evidence.bent).
void count_bend(BundleCovariance& covariance, const MisfitEvidence& evidence, double sigma);

// Warns of residuals that differ from place to place, and of halves of the views that differ by
// more than their noise explains.
void warn_of_misfit(Calibration& c, const MisfitEvidence& evidence);

// Warns of a bend beyond what a board is capable of: a hundredth of its diagonal.
bool warn_of_impossible_bend(Calibration& c, const BoardWarp& warp, const FlatBoard& board);

}  // namespace tagcal::internal
