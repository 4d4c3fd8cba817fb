#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/status.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal {

struct CalibrateOptions {
  std::string model;    // a name of the ladder; "" or "auto": opencv5 or fisheye4, by BIC
  double sigma_px = 0;  // noise per coordinate; 0: estimated from the residuals
  bool reject_outliers = true;
  int max_iterations = 100;  // of each solve
};

// One corner that was left out, with its residual under the answer.
struct Outlier {
  std::string image;
  CornerId id;
  double residual_px = 0;  // NaN where the answer does not project it at all
};

struct CalibratedView {
  std::string image;
  Pose camera_from_world;
  Matrix6 covariance = Matrix6::Zero();  // of (omega rad, tau m) in the camera frame: `retract`
  int num_corners = 0;                   // inliers
  double rms_px = 0;
};

// Wall-clock times.
struct CalibrateSeconds {
  double start = 0;  // closed form and consensus
  double solve = 0;
  double covariance = 0;
  double total = 0;
};

struct Calibration {
  Status status = Status::degenerate;
  std::string model;
  // No value without an estimate (degenerate, no_consensus). With a status that is no answer, the
  // lens is where the solver stood, for diagnosis only.
  std::optional<Camera> camera;
  Eigen::MatrixXd covariance;  // of the model's free parameters, in their order; empty if singular
  std::vector<double> sigmas;  // standard deviation of each lens parameter; 0 for a held one
  double rms_px = 0;           // sqrt(sum |r|^2 / corners), inliers
  double sigma_px = 0;         // noise per coordinate that the covariance was computed with
  bool sigma_from_residuals = false;
  double bic = 0;
  int num_corners = 0;  // inliers
  int num_iterations = 0;
  std::vector<CalibratedView> views;  // those that take part
  std::vector<Outlier> outliers;
  std::vector<std::string> warnings;
  CalibrateSeconds seconds;
};

// Camera and all poses from the observations of one data set: closed-form start on consensus,
// maximum likelihood by Ceres, corners beyond 5 sigma rejected and the rest solved again,
// covariance from the exact inverse of the information. Throws Error for a model that is not known.
Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options = {});

}  // namespace tagcal
