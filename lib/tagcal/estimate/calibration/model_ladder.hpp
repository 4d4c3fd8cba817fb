#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// One model of the ladder, fitted.
struct Rung {
  Bundle bundle;
  BundleSummary summary;
  const CalibrationFit* fit = nullptr;  // whose corners these are
  Observability seen;
  double misfit = 0;  // squared residuals / noise^2; rejected corners count up to the bound
  double bic = std::numeric_limits<double>::infinity();  // all corners count up to it

  const Model& model() const { return *bundle.model; }
  bool has_pole = false;  // inside the image: not taken
  bool holds() const { return seen.status == Status::ok && summary.converged && !has_pole; }
};

// The rungs that stand for choice, in the order of the ladder.
struct Ladder {
  std::vector<Rung> rungs;
  double noise_square = 1;  // of one (whitened) coordinate
  int num_residuals = 0;
  bool whitened = false;
};

// The perspectives of the ladder on the same corners, up to `top`, each from the best one below it,
// so that a solver that stops at the fold of a lens leads no other there; or from `from`, where
// that explains more.
std::vector<Rung> climb(const Bundle& from, const Model& top, int max_iterations);

// What a ladder is made of; null where there is none, but for one of the first two. They must
// outlive the ladder.
struct LadderFits {
  const CalibrationFit* perspective = nullptr;
  const CalibrationFit* fisheye = nullptr;
  const CalibrationFit* other_perspective = nullptr;  // another start
};

// f, f+c, ... opencv8 on the corners of `perspective`, or on those of another fit where they
// explain more from its poses; and the fisheye as it is.
Ladder build_ladder(const LadderFits& fits, const CalibrateOptions& options);

}  // namespace tagcal::internal
