#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/fit.hpp"
#include "tagcal/estimate/observability.hpp"

namespace tagcal {

// What `auto` settles on.
struct ModelChoice {
  CalibrationFit fit;          // of the chosen model; of `f` where that is `weak`
  bool weak = false;           // nothing but scaled orthographic projection is left
  Status status = Status::ok;  // focal_not_observable, degenerate: weak; not_observable: see reason
  std::string reason;          // a sentence where status is not ok
  std::vector<ModelStep> steps;
};

// The smallest model that explains the data, of those that the data hold. The largest perspective
// and the fisheye are fitted with rejection of wrong corners; the perspectives of the ladder then
// one after the other on the same corners, each from the one below.
//   1. A model whose parameters the data do not hold (`observability`) is never taken, nor one that
//      contains it.
//   2. Of the others the lowest BIC wins, n = scalar residuals, each counted up to the rejection
//      bound (Torr, IJCV 2002), the noise that of the best fit. The fisheye bears a handicap of
//      three parameters: where both lenses bend to the same images, the ordinary one is meant.
//   3. Then the smallest perspective whose projection differs from the winner's by at most
//      t = max(0.1 px, half its own sd), RMS over the seen region at the median distance with the
//      pose taken out, and that puts no corner more than 0.25 px and five posterior deviations from
//      there (these need a sum of squares larger by 25 noise^2: Cauchy-Schwarz).
// A model that the data ask for (BIC, and 0.1 px RMS) but cannot hold makes the answer
// not_observable. No value where no view has a consensus.
std::optional<ModelChoice> choose_model(const CalibrationInput& input,
                                        const CalibrateOptions& options);

}  // namespace tagcal
