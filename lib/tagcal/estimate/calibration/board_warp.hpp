#pragma once

#include <optional>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// How the board of a solved bundle is bent, beside its free parameters: one Gauss-Newton step from
// a flat board, with poses and parameters free, from the information with the bend. No value where
// it cannot be told.
std::optional<BoardWarp> estimate_warp(const BundleInformation& information, double sigma);

// Bends the points of the input as its corners ask, with the asked model, or the larger of the
// ladder (perspective or fisheye, what fits better) where it is to be chosen. Returns the bend, in
// metres; zero where it cannot be told.
Eigen::Vector2d unbend(CalibrationInput& input, const FlatBoard& board,
                       const CalibrateOptions& options);

}  // namespace tagcal::internal
