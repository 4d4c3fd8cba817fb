#pragma once

#include <optional>
#include <string>

#include "tagcal/estimate/fit.hpp"

namespace tagcal {

// For a fisheye that was asked for by its name: whether an ordinary lens (opencv5) explains the
// corners better by more than chance, a chi-square above 25. The two bend to nearly the same
// images, and residuals hardly show which it is; rejected corners do: both lenses are solved on
// what agrees with the ordinary one, and each corner counts, up to the bound of rejection. Asked of
// 20 views at most, where no corner is beyond 80 degrees from the axis. `sigma`: the noise.
std::optional<std::string> instead_of_fisheye(const CalibrationFit& fit,
                                              const CalibrationInput& input, double sigma);

}  // namespace tagcal
