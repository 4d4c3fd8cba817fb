#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"

namespace tagcal::internal {

// What `auto` settles on.
struct ModelChoice {
  CalibrationFit fit;          // of the chosen model; of `f` where that is `weak`
  bool weak = false;           // nothing but scaled orthographic projection is left
  Status status = Status::ok;  // focal_not_observable, degenerate: weak; not_observable: see reason
  std::string reason;          // a sentence where status is not ok
  std::vector<ModelStep> steps;
  std::vector<SupportedModel> supported;  // beside the chosen one; count in its claims
};

// The model that the data support best. The largest perspective and the fisheye are fitted with
// rejection of wrong corners; the perspectives of the ladder then one after the other on the same
// corners, each from the one below.
//   1. A model whose parameters the data do not determine (`observability`) is never taken, nor one
//      that contains it while the smaller one explains the corners as well; nor one with a pole
//      inside the image.
//   2. Of the others the lowest BIC wins, n = scalar residuals, each counted up to the rejection
//      bound (Torr, IJCV 2002), the noise that of the best fit. The fisheye bears a handicap of
//      three parameters: where both lenses bend to the same images, the ordinary one is meant.
//   3. Then the smallest perspective that agrees with the winner within the winner's own standard
//      deviation at every node over the image; or, with a tolerance, the smallest that projects
//      within it, RMS over the seen region at the median distance, the pose taken out.
// What the choice leaves out is in `supported`. A model that the data ask for (BIC, and more than
// the chosen one's own uncertainty) but do not determine makes the answer not_observable. No value
// where no view has a consensus.
std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options);

}  // namespace tagcal::internal
