#pragma once

#include <vector>

#include "study/method.hpp"
#include "study/peers/mrcal_peer.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/dataset.hpp"

// Calibrations that studies solve: 12 x 12 points, 0.66 m wide, seen by a camera of 1280 x 800.

namespace tagcal::study {

struct CalibrationTask {
  Dataset dataset;
  Lens lens = pinhole(1, 1, 0, 0);  // the truth
  std::string model;                // whose free parameters are asked for
  double sigma_px = 0;
  std::vector<Pose> camera_from_board;  // of the views
};

inline constexpr int kGridPoints = 12;  // across and down
inline constexpr double kGridSpacingM = 0.06;

// Views from 0.8 to 1.4 m with tilts up to 50 degrees; corners outside of the image are not seen.
CalibrationTask draw_calibration(const Lens& lens, const std::string& model, int num_views,
                                 Random& random);

// The information about the model's free parameters that the views hold, their poses unknown: its
// inverse is the Cramer-Rao bound.
Eigen::MatrixXd calibration_information(const CalibrationTask& task);

// The free parameters, or none.
using CalibrationAnswer = std::vector<double>;
using CalibrationMethod = Method<CalibrationTask, CalibrationAnswer>;

// mrcal's optimiser: as its own tool goes (the true f given, poses by cv::solvePnP, three stages),
// or alone, all at once, poses and f made beforehand. Precondition: has_mrcal().
CalibrationMethod mrcal_calibration(MrcalStages stages);

// Ours first; those that can fit the lens of the model.
std::vector<CalibrationMethod> calibration_methods(const std::string& model);

}  // namespace tagcal::study
