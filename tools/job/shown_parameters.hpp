#pragma once

#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// A lens parameter for the reports; NaN without an answer.
struct Shown {
  std::string_view name;
  double value = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();  // 0: held
};

// All parameters of the lens. The solver's last state without an answer is not shown, because it
// would look like an answer. Precondition: the calibration has a camera.
std::vector<Shown> shown_parameters(const Calibration& calibration);

// Number of parameters to print: OpenCV's vector of coefficients has five, eight for the rational
// model, four for the fisheye.
std::size_t num_shown(const Calibration& calibration);

// The largest standard deviation over the image.
double largest_px(const ProjectionUncertainty& projection);

// Number of nodes without a ray: they are beyond the fold of the distortion.
int nodes_without_ray(const ProjectionUncertainty& projection);

// Returns false for a standard deviation beyond the image's diagonal.
bool has_bound(double sigma_px, const ImageSize& size);

}  // namespace tagcal::tools
