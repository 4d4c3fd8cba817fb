#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// A fitted model of the ladder.
struct Candidate {
  Bundle bundle;
  BundleSummary summary;
  const CalibrationFit* fit = nullptr;  // the source of the inliers
  Observability observability;
  double chi_square = 0;  // squared residuals / noise_square; outliers count up to the bound
  double bic = std::numeric_limits<double>::infinity();  // all corners count up to the bound
  bool has_pole = false;                                 // inside the image

  const Model& model() const { return *bundle.model; }
  bool is_fisheye() const { return model().lens_type() == LensType::fisheye; }
  // Only usable candidates can be chosen.
  bool is_usable() const {
    return observability.status == Status::ok && summary.converged && !has_pole;
  }
};

// All candidates, from the smallest model to the largest, then the fisheye.
struct ModelLadder {
  std::vector<Candidate> candidates;
  double noise_square = 1;  // of one (whitened) coordinate
  int num_residuals = 0;
  bool whitened = false;
};

// The nested perspective models up to `top` on the same corners. Each starts from the best smaller
// one, so that a fit that stopped at the fold of a lens is no start of another; or from `from`, if
// that has the lower cost.
std::vector<Candidate> fit_nested(const Bundle& from, const Model& top, int max_iterations);

// The fits from which a ladder starts; null if missing, but not both of the first two. They must
// outlive the ladder.
struct LadderFits {
  const CalibrationFit* perspective = nullptr;
  const CalibrationFit* fisheye = nullptr;
  const CalibrationFit* other_perspective = nullptr;  // a second start
};

// f, f+c, ... opencv8 on the inliers of `perspective`, or of another fit from whose poses a
// candidate reaches a lower BIC; and the fisheye as it is.
ModelLadder fit_ladder(const LadderFits& fits, const CalibrateOptions& options);

}  // namespace tagcal::internal
