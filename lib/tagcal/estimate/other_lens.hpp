#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/fit.hpp"

namespace tagcal {

// For a lens that was asked for by its name: whether one of the other kind explains the corners
// better by more than chance, a chi-square above 16: opencv5 instead of a fisheye, where no corner
// is beyond 80 degrees from the axis; fisheye4 instead of a perspective, where one is beyond 0.9
// focal lengths (the two part there). They bend to nearly the same images, and residuals hardly
// show which it is; rejected corners do: each corner counts, up to the bound of rejection. Asked of
// 20 views at most. `fit`: of `input` as it was given, before views that stand out were left out.
// `sigma`: the noise.
std::optional<std::string> better_other_lens(const CalibrationFit& fit,
                                             const CalibrationInput& input,
                                             const CalibrateOptions& options, double sigma);

}  // namespace tagcal
