#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/lack_of_fit.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"
#include "tagcal/estimate/checks/target_error.hpp"

namespace tagcal::internal {

// A fit, and what belongs to it.
struct Solution {
  const CalibrationInput* input = nullptr;
  const CalibrationFit* fit = nullptr;
  const CalibrateOptions* options = nullptr;
  const FlatBoard* board = nullptr;              // null: none, or several
  std::span<const SupportedModel> supported;     // other models that the data support, of `auto`
  std::optional<Finding> refusal;                // of the choice of a model
  const AlternativeLens* alternative = nullptr;  // the trial that the fit needs; or null
};

// Evidence of the residuals of a fit about the noise, the model, the board and the target.
struct Evidence {
  // Noise per (whitened) coordinate: as stated, that of the corners, that of the residuals, or
  // policy::kAssumedSigmaPx.
  double sigma = 0;
  bool sigma_from_residuals = false;
  // At least `least_sigma`: below it the rounding of a file would count as lack of fit.
  double floored_sigma = 0;
  std::optional<BundleInformation> information;  // with the bends of the board
  Observability observability;
  bool at_minimum = false;  // converged, and no Gauss-Newton step lowers the cost further
  SeenRegion seen;          // the corners
  double distance_m = 0;    // their median

  // Lack of fit; unset if the observability has no covariance.
  ResidualBias bias;
  std::optional<HalvesCheck> halves;
  std::optional<LargerLens> larger;
  std::optional<BoardWarp> bend;
  double bend_chi_square = 0;  // of a flat board, in units of floored_sigma
  std::optional<TargetError> target;

  Eigen::MatrixXd model_covariance;  // of the free parameters, without the other supported models
  double seconds = 0;                // that it took, wall clock

  // A larger lens explains more of the residuals than chance, and more than a bent board.
  bool is_model_small() const;
  // The residuals show a bend, and the model is not too small.
  bool is_board_bent() const;
  // Factor of all variances for residuals that are not independent: the larger one of the residual
  // bias and of the split-half check.
  double inflation() const;
};

// Evidence of the noise alone.
Evidence noise_of(const CalibrationFit& fit, const CalibrateOptions& options);

// Collects the evidence for a fit with its noise, and widens the covariance by all that it assumed:
// the linear approximation (profile likelihood), independent residuals (inflation), a flat board,
// and the model (the other supported ones).
Evidence gather_evidence(const Solution& solution);

// A model fixes some parameters, and its standard deviations take them as exact. The next two
// return a sentence if the views cannot test such an assumption and it matters.

// For a solved bundle of model f, which fixes the principal point at the centre of the image: with
// a free principal point (with the spread that cameras have as its prior) the standard deviation of
// the focal length would be policy::kMuchLargerSd times as large. No value for another model.
std::optional<std::string> untested_principal_point(const Bundle& solved, double sigma);

// The standard deviation of the projection at the corners of the image (at infinity) exceeds 0.5 %
// of its diagonal; or, for a perspective smaller than opencv5, it would exceed half a pixel and 1.5
// times its value with opencv5's coefficients free. The views show distortion only where their
// corners are. `samples`: as those of `projection_uncertainty`.
std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples);

// The bend is larger than policy::kLargestBoardBend allows.
bool is_impossible(const BoardWarp& bend, const FlatBoard& board);

}  // namespace tagcal::internal
