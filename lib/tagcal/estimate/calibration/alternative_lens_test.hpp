#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// A lens that was asked for by its name, and what it was fitted to.
struct LensQuestion {
  CalibrationFit fit;      // of all views
  CalibrationInput input;  // 20 of them at most
  bool all_views = true;
};

// Whether the other kind of lens is worth asking: opencv5 instead of a fisheye, where no corner is
// beyond 80 degrees from the axis; fisheye4 instead of a perspective, where one is beyond 0.9 focal
// lengths (the two part there). `fit`: of `input` as it was given, before views that stand out were
// left out.
std::optional<LensQuestion> question_of_lens(const CalibrationFit& fit,
                                             const CalibrationInput& input);

// Whether the other kind explains the corners better by more than chance, a chi-square above 16.
// The two bend to nearly the same images, and residuals hardly show which it is; rejected corners
// do: each corner counts, up to the bound of rejection. `sigma`: the noise.
std::optional<std::string> better_other_lens(const LensQuestion& question,
                                             const CalibrateOptions& options, double sigma);

}  // namespace tagcal::internal
