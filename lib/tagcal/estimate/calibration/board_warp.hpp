#pragma once

#include <optional>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"

namespace tagcal::internal {

// The bend of the board of a solved bundle: one Gauss-Newton step from a flat board, with poses and
// parameters free. `information` includes the bend. No value if the bend is not determined.
std::optional<BoardWarp> estimate_warp(const BundleInformation& information, double sigma);

// Estimates the bend and applies it to the points of the input. The model is the given one; with
// `auto` the better fitting one of opencv5 and fisheye4. Returns the bend in metres, zero if it is
// not determined.
Eigen::Vector2d remove_board_warp(CalibrationInput& input, const FlatBoard& board,
                                  const CalibrateOptions& options);

}  // namespace tagcal::internal
