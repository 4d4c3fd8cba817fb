#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// A model of the ladder.
struct Candidate {
  Bundle bundle;
  BundleSummary summary;
  const CalibrationFit* fit = nullptr;  // the source of the inliers
  Observability observability;
  double chi_square = 0;  // squared residuals / noise_square; outliers count up to the bound
  double bic = std::numeric_limits<double>::infinity();  // all corners count up to the bound
  bool has_pole = false;                                 // inside the image
  bool is_estimated = false;  // fitted to a part of the views; chi_square and bic are for all

  const Model& model() const { return *bundle.model; }
  bool is_fisheye() const { return model().lens_type() == LensType::fisheye; }
  bool is_determined() const { return observability.status == Status::ok; }
  // Only usable candidates can be chosen.
  bool is_usable() const {
    return is_determined() && summary.converged && !has_pole && !is_estimated;
  }
};

// All candidates, from the smallest model to the largest, then the fisheye.
struct ModelLadder {
  std::vector<Candidate> candidates;
  double noise_square = 1;  // of one (whitened) coordinate
  int num_residuals = 0;
  bool whitened = false;
  bool may_estimate = false;  // models that cannot win are not fitted

  double sigma() const;  // 1 if whitened
};

// The robust fits from which a ladder starts; not none. They must outlive the ladder.
struct LensFits {
  std::vector<CalibrationFit> perspectives;  // one of them decides the inliers: the first
  std::optional<CalibrationFit> fisheye;
};

// f, f+c, ... opencv8 on the inliers of the first perspective fit, or of another fit from whose
// poses a candidate reaches a lower BIC; and the fisheye as it is. If `may_estimate`, models that
// cannot win (a score test) are not fitted.
ModelLadder fit_ladder(const LensFits& fits, bool may_estimate, const CalibrateOptions& options);

// The ladder of all views. `few`: that of a part of them; `fit`: of the model of few's `best`, to
// all views. Fits those of its kind of lens that may win: models within policy::kStrongEvidence of
// BIC on the few views, and larger ones that come as near by a Gauss-Newton step on all views.
// `rival`: a fit of the other kind to all views, or null. The others are estimated: their
// differences in chi-square grow with the number of corners.
ModelLadder fit_contenders(const ModelLadder& few, const Candidate& best, const CalibrationFit& fit,
                           const CalibrationFit* rival, const CalibrateOptions& options);

}  // namespace tagcal::internal
