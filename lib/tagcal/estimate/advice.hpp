#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// A view to take next.
struct AdvisedView {
  Pose camera_from_board;
  double tilt_rad = 0;    // between the board's normal and the line of sight
  double distance_m = 0;  // of the board's centre
  Eigen::Vector2d pixel;  // of the board's centre
  // Standard deviation of f (the larger of fx and fy) after this view, for the same noise; and now,
  // infinite if f is not determined.
  double focal_sigma_px = 0;
  double focal_sigma_now_px = 0;
  double projection_px = 0;        // sd of the projection at infinity after it, RMS over the image
  std::vector<std::string> fills;  // SeenRegion::missing_parts that it covers
  std::string sentence;            // the view and its effect, for users
  std::string instruction;         // the view alone: "show the board .."
};

// Finds the view after which the projection at infinity has the least variance over the image, by
// the information that each candidate adds. Candidates are views of the largest board: facing the
// camera or tilted by up to 55 degrees to eight sides, in nine places and at four distances. If the
// lens has distortion, the candidate that fills most missing parts of the seen region is taken of
// those with at most twice the least variance. If the calibration has no focal length, a nominal
// one is assumed. No value without a camera, or if no candidate shows half of the board.
std::optional<AdvisedView> advise(const Dataset& dataset, const Calibration& calibration);

}  // namespace tagcal
