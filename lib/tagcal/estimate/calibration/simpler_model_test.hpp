#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// An over-parameterised model can report a small linearised covariance although a nested, simpler
// model fits as well: coefficients that fit the noise have curvature, and curvature determines a
// centre and a focal length. So lenses without distortion are fitted, too. Returns a refusal if
//   1. model f fits as well (by BIC), and its focal length is not observable;
//   2. f+c or pinhole fits as well, and is not observable; or
//   3. its distance from the estimate is many standard deviations: at d of them the cost should be
//      higher by d^2 sigma^2 (policy::kCurvedCost).
// No value otherwise. A few views are tested first: if a plain lens does not explain these, it does
// not explain all. `covariance`: of the free parameters of the solved bundle.
std::optional<Observability> simpler_model_test(const Bundle& solved,
                                                const Eigen::MatrixXd& covariance, double sigma);

// All corners are within policy::kPerspectiveCosine (80 degrees) of the axis, so a perspective lens
// can see them.
bool within_perspective_field(const Bundle& bundle);

// The same poses, with the lens in the parameters of another model.
Bundle with_model(const Bundle& bundle, const Model& model);

// The normal equations of a solved perspective, its poses eliminated, by the parameters of opencv8:
// those of every nested model are parts of them.
std::optional<BundleInformation> nested_information(const Bundle& solved);

// A Gauss-Newton step from a solved bundle to a model that contains its own: what the larger model
// would gain, without a fit (score test: Rao, Proc. Camb. Phil. Soc. 1948).
struct LargerModelStep {
  Bundle bundle;                // the same state, in the parameters of the larger model
  BundleCovariance covariance;  // of the larger model there
  Eigen::VectorXd step;         // of its free parameters
  double chi_square = 0;        // decrease of the sum of squares, in units of sigma^2
};

// `nested`: nested_information of the bundle. The principal point has a prior
// (policy::kCentreSpread) if only the larger model has it free. Coefficients that the data do not
// determine get a large standard deviation (policy::kUnobservablePrecision). No value if the
// information is not finite.
std::optional<LargerModelStep> step_to_larger_model(const Bundle& solved,
                                                    const BundleInformation& nested,
                                                    const Model& larger, double sigma);

// The gain of opencv5 over a solved perspective with fewer parameters, to first order.
struct LargerLens {
  double chi_square = 0;  // decrease of the sum of squares, in units of sigma^2
  double share = 0;       // of the sum of squares
};

// No value for a model that is not smaller, or if the data do not determine opencv5.
std::optional<LargerLens> larger_lens(const Bundle& solved, double sigma);

// A fit of a model that the user named, and the views on which the other kind of lens is tried.
struct AlternativeLens {
  CalibrationFit fit;      // to all views
  CalibrationInput input;  // at most 20 of them
  bool all_views = true;
};

// The input with at most `count` of its views, evenly spread.
CalibrationInput spread_views(const CalibrationInput& input, std::size_t count);

// The views for a trial of the other kind of lens: of opencv5 instead of a fisheye, if all corners
// are within 80 degrees of the axis; of fisheye4 instead of a perspective, if a corner is at
// policy::kWideFocalLengths from the principal point, where the two lenses differ. No value if no
// trial is needed. `fit`: to `input` before outlying views are rejected.
std::optional<AlternativeLens> alternative_lens(const CalibrationFit& fit,
                                                const CalibrationInput& input);

// A sentence if the other kind of lens explains all corners better by more than
// policy::kOtherLensChiSquare. Each corner counts up to the rejection bound, rejected ones
// included: the inliers alone hardly distinguish the two lenses. `sigma`: the noise.
std::optional<std::string> alternative_lens_test(const AlternativeLens& alternative,
                                                 const CalibrateOptions& options, double sigma);

}  // namespace tagcal::internal
