#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/scene/dataset.hpp"

// Pose, and focal length, of the camera of one view: the most likely answer, its covariance, and
// the reason where the view does not determine it.

namespace tagcal {

// Returns the pose of a calibrated camera before a target, from four points or more that are not on
// a line. Every point of an answer lies in the lens' domain, in front of the camera. The answer
// does not depend on the unit of length or on the place of the target in its frame.
PoseEstimate estimate_pose(std::span<const Correspondence> correspondences, const Camera& camera,
                           const PoseOptions& options = {});

// The same for the corners of a view (view_correspondences), with their groups and, unless the
// options state the noise, their covariances.
PoseEstimate estimate_pose(const ViewCorrespondences& seen, const Camera& camera,
                           const PoseOptions& options = {});

// The same pose, whose covariance includes that of the camera (bundle/held_lens.hpp). Throws Error
// if that does not have the size of its model.
PoseEstimate estimate_pose(const ViewCorrespondences& seen, const UncertainCamera& camera,
                           const PoseOptions& options = {});

// Returns pose and focal length of a pinhole with square pixels and its principal point in the
// centre of the image, from four points or more: in a plane that is tilted enough, or in space. The
// standard deviations include what lenses are instead (PoseAndFocalOptions::exact_pinhole). The
// focal length is refused (focal_not_observable) if sd(f) / f exceeds 10 % at the estimate, if weak
// perspective explains the view as well, or if the residuals show that the lens is no pinhole.
PoseAndFocalEstimate estimate_pose_and_focal(std::span<const Correspondence> correspondences,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options = {});
PoseAndFocalEstimate estimate_pose_and_focal(const ViewCorrespondences& seen,
                                             const ImageSize& image_size,
                                             const PoseAndFocalOptions& options = {});

// The pose of a calibrated rig before a target, from all of its cameras at one instant: minimises
// the squared residuals of all cameras, in units of their noise, from each pose that a
// camera alone finds (estimate_pose), without the corners that it rejects. A second pose that one
// camera cannot exclude is excluded by the others: the probabilities are those of all residuals. A
// camera whose own pose contradicts that of the others does not take part (the finding
// camera_contradicts); of two it cannot be said which one is wrong, so that there is no answer
// (pair_contradicts). `seen`: one for each camera, without corners if it sees none. At least one
// camera must determine a pose alone. Throws Error if the numbers of cameras differ.
RigPoseEstimate estimate_rig_pose(std::span<const ViewCorrespondences> seen, const KnownRig& rig,
                                  const PoseOptions& options = {});

// Where the camera is in the target's frame, and where it looks. Azimuth: of the optical axis about
// z of the target, from +x towards +y; elevation: of the optical axis above the target's xy-plane,
// towards +z; roll: of the camera about the optical axis, clockwise as seen from behind it, 0 if z
// of the target is up in the image. The ranges are those of roll_pitch_yaw
// (geometry/viewpoint.hpp).
struct CameraInTarget {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double roll_rad = 0;
  // The optical axis is along z of the target: azimuth and roll are one valid choice, and their
  // rows and columns of the covariance are NaN.
  bool gimbal_lock = false;
  // Of (position, azimuth, elevation, roll), by linearisation.
  Matrix6 covariance = Matrix6::Zero();
};
CameraInTarget camera_in_target(const PoseHypothesis& hypothesis);

// The poses of the views of a data set under a camera that is known, in the form of a calibration's
// views. Each pose is estimated by itself.
struct ViewPoses {
  std::vector<CalibratedView> views;    // those with a pose
  std::vector<Outlier> outliers;        // of these; NaN residuals are outside of the lens' domain
  std::vector<Eigen::Vector2d> pixels;  // the other corners
  double rms_px = 0;                    // of these
  // Noise per coordinate that all residuals show, six coordinates of each view having gone into its
  // pose; from 50 degrees of freedom on, else 0.5 px, and the finding `noise_assumed` if a view has
  // no covariances of its corners.
  double sigma_px = 0;
  bool sigma_from_residuals = false;
  std::vector<Finding> findings;  // also of views that have corners and no pose
};

// `views`: indices, in the order of the result. `camera_error_px` as view_correspondences has it.
// The answer does not depend on the number of threads (0: one per core).
ViewPoses poses_of_views(const Dataset& dataset, std::span<const std::size_t> views,
                         const Camera& camera, const std::optional<double>& camera_error_px,
                         std::size_t num_threads = 1);

// The same for all views.
ViewPoses poses_of_views(const Dataset& dataset, const Camera& camera,
                         const std::optional<double>& camera_error_px, std::size_t num_threads = 1);

}  // namespace tagcal
