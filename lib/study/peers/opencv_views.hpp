#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "study/peers/mrcal_peer.hpp"
#include "tagcal/scene/rig.hpp"

// Data sets in the form of the peers' calibrations. Private to study.

namespace tagcal::study {

// The views with at least four corners in OpenCV's form, in single precision, and its results.
struct OpenCvViews {
  explicit OpenCvViews(const Dataset& dataset);

  // cv::calibrateCamera with standard deviations; cv::fisheye::calibrate with
  // CALIB_RECOMPUTE_EXTRINSIC | CALIB_FIX_SKEW.
  void calibrate(int flags);
  void calibrate_fisheye();

  // fx fy cx cy and the coefficients.
  std::vector<double> values() const;

  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  cv::Size size;
  cv::Mat k, distortion, deviations;
  std::vector<cv::Mat> turns, moves;
};

// By mrcal (mrcal_peer.hpp), of one board: a square grid of points that are numbered row by row.
// The initial poses are those of cv::solvePnP for a pinhole with the focal length; cameras of a rig
// begin where the first instant that they share with the first camera has them.
MrcalProblem mrcal_problem(const Dataset& dataset, double focal_px);
std::vector<double> calibrate_by_mrcal(const Dataset& dataset, double focal_px);
// The poses of all cameras, from the first; none if a camera shares no instant with it.
std::vector<Pose> calibrate_rig_by_mrcal(const RigDataset& rig, double focal_px);

}  // namespace tagcal::study
