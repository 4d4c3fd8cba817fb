#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "study/peers/mrcal_peer.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to study: data sets as the peers' calibrations take them.

namespace tagcal::study {

// The views of four corners and more as OpenCV takes them, in single precision, and what it gave.
struct OpenCvViews {
  explicit OpenCvViews(const Dataset& dataset);

  // fx fy cx cy and the coefficients.
  std::vector<double> values() const;

  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  cv::Size size;
  cv::Mat k, distortion, deviations;
  std::vector<cv::Mat> turns, moves;
};

// Of one board, a square grid of points that are numbered row by row. The poses start from
// cv::solvePnP of a pinhole with the focal length.
MrcalProblem mrcal_problem(const Dataset& dataset, double focal_px);

}  // namespace tagcal::study
