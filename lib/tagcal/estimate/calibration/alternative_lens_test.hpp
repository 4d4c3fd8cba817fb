#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

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
