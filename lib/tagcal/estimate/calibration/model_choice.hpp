#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"

namespace tagcal::internal {

// The choice of `auto`.
struct ModelChoice {
  CalibrationFit fit;          // of the chosen model; of `f` if that is `weak`
  bool weak = false;           // only scaled orthographic projection is determined
  Status status = Status::ok;  // focal_not_observable, degenerate: weak; not_observable: see reason
  std::string reason;          // a sentence if status is not ok
  std::vector<ModelStep> steps;
  std::vector<SupportedModel> supported;  // other models, part of the standard deviations
};

// Chooses the model that the data support best. opencv5 and the fisheye are fitted with rejection
// of outliers, then the nested perspective models on the same inliers, each from the next smaller
// one.
//   1. Excludes models that the data do not determine (`observability`); models that contain one
//      without an observable focal length, unless their BIC is lower; and models with a pole inside
//      the image.
//   2. The lowest BIC wins: n scalar residuals, each counted up to the rejection bound (Torr, IJCV
//      2002), with the noise of the best fit. The fisheye has a handicap
//      (policy::kFisheyeHandicap).
//   3. Takes the smallest perspective that agrees with the winner within the winner's standard
//      deviation at every node of the image; or, with a tolerance, the smallest whose projection
//      differs by less, RMS over the seen region at the median distance, after the best relative
//      pose.
// More than policy::kChoiceViews views are compared on that many first; then the three rules decide
// on all views among the models that may still win (fit_contenders). The other models that the data
// support are in `supported`. The status is not_observable if a model that the data do not
// determine is better by policy::kStrongEvidence of BIC. No value if no view has a consensus.
std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options);

}  // namespace tagcal::internal
