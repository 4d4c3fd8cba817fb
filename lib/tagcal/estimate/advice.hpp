#pragma once

#include <Eigen/Core>
#include <cstddef>
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

// A view that was selected, and what it adds to those before it.
struct SelectedView {
  std::size_t view = 0;  // index in Dataset::views
  std::string image;
  int num_corners = 0;  // that took part in the calibration
  // Standard deviation of the projection at infinity (px per coordinate, RMS over the image) by
  // this view and those before it; infinite as long as they do not determine all parameters.
  double projection_px = 0;
};

struct ViewSelection {
  std::vector<SelectedView> views;  // in the order of selection
  double all_px = 0;                // the same standard deviation by all views
};

// Ends a selection before its count: at a standard deviation (px; 0: no goal), and before a view
// that would reduce the variance by less than a share of it.
struct SelectionEnd {
  double goal_px = 0;
  double least_gain = 0;
};

// Selects the `count` most informative views of a calibration (all of its views, if it has fewer):
// each next one is the view after which the projection at infinity has the least variance over the
// image, the measure of `advise`. Information is that of the corners with unknown poses, at the
// calibration's lens and poses and for its noise and variance_inflation. Until the views determine
// all parameters, a millionth of the information of all views is added. Of equal views the first is
// taken: the answer does not depend on chance. Rejected views are not selected. Empty if the
// calibration has no covariance. `dataset`: the one that was calibrated; 1 <= count.
ViewSelection select_views(const Dataset& dataset, const Calibration& calibration, int count,
                           const SelectionEnd& end = {});

}  // namespace tagcal
