#pragma once

#include <optional>

#include "tagcal/estimate/fit.hpp"

namespace tagcal {

// The one flat board of a data set, for two-parameter bending: a point at (x, y) of the board moves
// out of its plane by bend.x (1 - x'^2) + bend.y (1 - y'^2), x' and y' from -1 to 1 over the board
// (after mrcal's calobject_warp).
struct FlatBoard {
  Pose world_from_board;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d half_size = Eigen::Vector2d::Ones();

  Eigen::Vector2d shape(const Eigen::Vector3d& x_in_world) const;  // (1 - x'^2, 1 - y'^2)
  Eigen::Vector3d normal_in_world() const;                         // towards the viewer
};

// No value for several boards, or one with thickness or without extent.
std::optional<FlatBoard> flat_board(const Dataset& dataset);

// How the board of a solved bundle is bent, beside its free parameters: one Gauss-Newton step from
// a flat board, with poses and parameters free. No value where it cannot be told.
std::optional<BoardWarp> estimate_warp(const Bundle& solved, const FlatBoard& board, double sigma);

// Bends the points of the input as its corners ask, with the asked model, or the larger of the
// ladder (perspective or fisheye, what fits better) where it is to be chosen. Returns the bend, in
// metres; zero where it cannot be told.
Eigen::Vector2d unbend(CalibrationInput& input, const FlatBoard& board,
                       const CalibrateOptions& options);

}  // namespace tagcal
