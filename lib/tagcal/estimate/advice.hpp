#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal {

// A combination of parameters that the data leave open, by what it does to the projection.
std::vector<WeakDirection> weak_directions(const UncertainLens& lens,
                                           std::span<const Eigen::Vector2d> samples);

// The view to take next.
struct AdvisedView {
  Pose camera_from_board;
  double tilt_rad = 0;        // between the board's normal and the line of sight
  double distance_m = 0;      // of the board's centre
  Eigen::Vector2d pixel;      // where the board's centre is seen
  double focal_sigma_px = 0;  // sd of f after it (of fx or fy, the larger), for the noise at hand
  double focal_sigma_now_px = 0;   // infinite where f is not known
  double projection_px = 0;        // sd of the projection at infinity, RMS over the image, after it
  std::vector<std::string> fills;  // the missing parts of the image that it shows: `SeenRegion`
  std::string sentence;
};

// Of views of the largest board, from frontal to tilted by 55 degrees to eight sides, in nine
// places and at four distances, the one after which the projection at infinity is best known over
// the whole image: each is judged by the information that it adds. Of those that leave at most
// twice that variance the one that fills most gaps in the seen region, where the lens has
// distortion to learn. For a calibration that holds no
// focal length, a nominal one stands in. No value without an estimate, or where no view shows half
// of the board.
std::optional<AdvisedView> advise(const Dataset& dataset, const Calibration& calibration);

}  // namespace tagcal
