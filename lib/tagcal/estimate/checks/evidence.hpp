#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "tagcal/estimate/bundle/lack_of_fit.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/model_choice.hpp"
#include "tagcal/estimate/checks/target_error.hpp"

namespace tagcal::internal {

// An answer, and what belongs to it.
struct Solution {
  const CalibrationInput* input = nullptr;
  const CalibrationFit* fit = nullptr;  // of the answer
  const CalibrateOptions* options = nullptr;
  const ModelChoice* choice = nullptr;  // null for model weak
  std::optional<Finding> refusal;       // of the fit with perspective, for model weak
};

// The gain of opencv5 over a solved perspective with fewer parameters, to first order (score test:
// Rao, Proc. Camb. Phil. Soc. 1948).
struct LargerLens {
  double chi_square = 0;  // decrease of the sum of squares, in units of sigma^2
  double share = 0;       // of the sum of squares
};

// Evidence of the residuals of a fit about the noise, the model, the board and the target.
struct Evidence {
  BundleNoise noise;
  // At least `least_sigma`: below it the rounding of a file would count as lack of fit.
  double floored_sigma = 0;
  Observability observability;
  bool at_minimum = false;  // converged, and no Gauss-Newton step lowers the cost further
  SeenRegion seen;          // the corners
  double distance_m = 0;    // their median

  ResidualBias bias;
  std::optional<HalvesCheck> halves;
  std::optional<LargerLens> larger;  // for a model by name
  // Factor by which the standard deviation of the focal length would grow if the principal point of
  // a model that was asked for were free, within its prior; 1 if it is.
  double open_centre = 1;
  std::optional<BoardWarp> board;
  std::optional<TargetError> target;
  double seconds = 0;  // that it took, wall clock

  // A larger lens explains more of the residuals than chance.
  bool is_model_small() const;
};

// Evidence of the noise alone.
Evidence evidence_of_noise(const CalibrationFit& fit, const CalibrateOptions& options);

// Collects the evidence for an answer.
Evidence gather_evidence(const Solution& solution);

// A bend or the twist is larger than policy::kLargestBoardBend allows.
bool is_impossible(const BoardWarp& board, const FlatBoard& flat);

}  // namespace tagcal::internal
