#pragma once

#include <functional>
#include <vector>

#include "study/method.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/dataset.hpp"

// Calibrations for studies: 12 x 12 points, 0.66 m wide, seen by a camera of 1280 x 800 pixels.

namespace tagcal::study {

struct CalibrationTask {
  Dataset dataset;
  Lens lens = pinhole(1, 1, 0, 0);  // the truth
  std::string model;                // its free parameters are estimated
  double sigma_px = 0;
  std::vector<Pose> camera_from_board;  // of the views
};

inline constexpr int kGridPoints = 12;  // across and down
inline constexpr double kGridSpacingM = 0.06;

// Adds a noisy view of the points that are in the image and in the lens' domain, and for which
// `seen` returns true.
void add_view(CalibrationTask& task, const Pose& camera_from_board, Random& random,
              const std::function<bool(const Eigen::Vector2d&)>& seen = {});

// Views from 0.8 to 1.4 m with tilts up to 50 degrees; corners outside of the image are not seen.
CalibrationTask draw_calibration(const Lens& lens, const std::string& model, int num_views,
                                 Random& random);

// The information of the views about the model's free parameters, with unknown poses; its inverse
// is the Cramer-Rao bound.
Eigen::MatrixXd calibration_information(const CalibrationTask& task);

// The free parameters; empty if there is no answer.
using CalibrationAnswer = std::vector<double>;
using CalibrationMethod = Method<CalibrationTask, CalibrationAnswer>;

// The methods that can fit the lens of the model, ours first.
std::vector<CalibrationMethod> calibration_methods(const std::string& model);

}  // namespace tagcal::study
