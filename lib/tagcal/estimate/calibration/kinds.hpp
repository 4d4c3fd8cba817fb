#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tagcal/estimate/calibration/posterior.hpp"

namespace tagcal::internal {

// chi-square of all corners, each up to the rejection bound, and of the priors, for the noise of
// `noise`; with what the evidence charges for row terms.
double chi_square(const CalibrationFit& fit, const Posterior& noise);
// Bayes' information criterion of a model with this chi-square, on the data of `posterior`.
double bic(const Model& model, double chi_square, const Posterior& posterior);

// The posterior of a model. No value if no view has a consensus, or a view does not determine its
// pose.
std::optional<Posterior> fit_posterior(const Model& model, const CalibrationInput& input,
                                       const CalibrateOptions& options);
// The same from the lens `start`, without a search for one.
std::optional<Posterior> fit_posterior_from(const Lens& start, const Model& model,
                                            const CalibrationInput& input,
                                            const CalibrateOptions& options);

// The posteriors of the kinds of lens on the same views.
struct Kinds {
  std::optional<Posterior> polynomial, rational, fisheye;
  std::vector<Posterior> spheres;  // double sphere, extended unified

  std::vector<const Posterior*> all() const;
};

// Fits the largest perspective (and, on its inliers, the one without a denominator) and the
// fisheye. A rational lens of a wide field has many minima: without a solution, or with one that
// explains the corners worse than the fisheye, it is tried again from that one's lens. Without any,
// the polynomial is fitted by itself. Where the fisheye is the best of these, the lenses of fewer
// parameters that reach behind the camera are fitted to its inliers, from its lens, and kept if
// they explain the corners better all the same.
Kinds fit_kinds(const CalibrationInput& input, const CalibrateOptions& options);

// The posterior of the lowest BIC. A lens that reaches behind the camera is charged
// policy::kFisheyeCharge parameters more than a polynomial: where both describe the same images,
// the ordinary lens is meant.
const Posterior* best_of(const Kinds& kinds);

// The share of chi-square that opencv5 explains beyond a fisheye that the user named, on at most
// policy::kChoiceViews views; 0 if that is chance.
double gain_of_perspective(const Posterior& named, const CalibrationInput& input,
                           const CalibrateOptions& options);

// The input without its views.
CalibrationInput without_views(const CalibrationInput& input);

// The input with at most `count` of its views, evenly spread: all of them if it has no more.
CalibrationInput spread_views(const CalibrationInput& input, std::size_t count);

}  // namespace tagcal::internal
