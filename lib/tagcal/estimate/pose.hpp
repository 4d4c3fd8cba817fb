#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/status.hpp"
#include "tagcal/estimate/weak_perspective.hpp"

// Where one view was taken from, and with what focal length: the most likely answer, how sure it
// is, and what the view cannot tell.

namespace tagcal {

// A point of a target and the pixel at which it is seen.
struct Correspondence {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // target frame, metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct PoseOptions {
  double sigma_px = 0;  // noise per coordinate; 0: from the residuals where there are 50 degrees of
                        // freedom, else 0.5 px is assumed, and a warning says so
  int max_iterations = 50;
  bool reject_outliers = true;  // where not all agree, search for those that do
  std::uint64_t seed = 0;       // of the samples that the search takes
  // One per correspondence, or none.
  std::span<const Matrix2> covariance_px2 = {};  // of the pixel; sigma_px is not used then
  std::span<const int> groups = {};  // equal numbers are right or wrong together: a tag's id
};

struct PoseHypothesis {
  Pose camera_from_target;
  // Of (omega rad, tau m) in the camera frame: `retract`. Where turns are hardly known it is wider
  // than the inverse of the information, so that its ellipsoid holds what the likelihood does.
  Matrix6 covariance = Matrix6::Zero();
  double rms_px = 0;       // sqrt(sum |r|^2 / points), of the inliers
  double probability = 1;  // by likelihood, among the hypotheses
  double focal_px = 0;     // that goes with it, where it was estimated; else 0
};

struct PoseEstimate {
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // best first; two where a plane fits two poses
  std::vector<std::size_t> outliers;       // correspondences that were left out, ascending
  double sigma_px = 0;                     // what the covariance was computed with
  std::vector<std::string> warnings;

  // The likeliest pose. Precondition: is_answer(status).
  const Pose& camera_from_target() const { return hypotheses.front().camera_from_target; }
};

// The pose of a calibrated camera before a target, from four points or more that are not on a line.
// Every point of an answer lies in the lens' domain, in front of the camera. Neither the unit of
// length nor the target's place in its frame matters.
PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options = {});

struct PoseAndFocalOptions : PoseOptions {
  double prior_focal_px = 0;  // what the caller takes the focal length for where the view does not
                              // show it; 0: nothing
};

using Matrix7 = Eigen::Matrix<double, 7, 7, Eigen::DontAlign>;

struct PoseAndFocalEstimate {
  Status status = Status::degenerate;

  // Of an answer: the focal length, its standard deviation and the covariance of (omega, tau, log
  // f) of the likeliest hypothesis, whose own covariance is the upper left block.
  double focal_px = 0;
  double sigma_focal_px = 0;
  Matrix7 covariance = Matrix7::Zero();

  // With focal_not_observable: the poses for the prior focal length (the prior taken as exact), if
  // there is one, best first; and what the view does hold, the poses under weak perspective.
  std::vector<PoseHypothesis> hypotheses;
  std::vector<WeakPerspectivePose> weak_perspective;

  std::vector<std::size_t> outliers;  // correspondences that were left out, ascending
  double sigma_px = 0;                // what the covariance was computed with
  std::vector<std::string> warnings;

  // Precondition: is_answer(status).
  const Pose& camera_from_target() const { return hypotheses.front().camera_from_target; }
};

// Pose and focal length of a pinhole with square pixels and its principal point in the centre of
// the image, from four points or more: in a plane that is tilted enough, or in space. The focal
// length is refused (focal_not_observable) where sd(f) / f exceeds 10 % at the estimate, where weak
// perspective explains the view as well, or where the residuals show that the lens is no pinhole.
PoseAndFocalEstimate estimate_pose_and_focal(std::span<const Correspondence> correspondences,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options = {});

}  // namespace tagcal
