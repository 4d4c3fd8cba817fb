#pragma once

#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"

namespace tagcal::tools {

// A parameter as it may be shown: NaN where there is no answer for it.
struct Shown {
  std::string_view name;
  double value = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();  // 0: held
};

// All parameters of the lens. Where the solver stood without an answer is not shown: it would look
// like one. Precondition: the calibration has a camera.
std::vector<Shown> shown_parameters(const Calibration& calibration);

// How many of them people know: OpenCV's vector of coefficients has five, eight for the rational
// model, four for the fisheye.
std::size_t num_shown(const Calibration& calibration);

// The largest standard deviation over the image.
double largest_px(const ProjectionUncertainty& projection);

// At how many nodes no ray meets the image: beyond where the lens folds.
int nodes_without_ray(const ProjectionUncertainty& projection);

// Whether a standard deviation says anything: one beyond the image's diagonal does not.
bool has_bound(double sigma_px, const ImageSize& size);

}  // namespace tagcal::tools
