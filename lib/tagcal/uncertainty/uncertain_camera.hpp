#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/model.hpp"

// A camera and its covariance, from which every uncertainty of a projection follows. Points to
// pixels and back, with covariances to first order: that of the input, and that of the lens' free
// parameters, which is independent of it. A lens and a pose that were estimated from one another
// are not: what a moved or turned camera could explain is part of these covariances too
// (projection_uncertainty subtracts it).

namespace tagcal {

// A camera and the covariance of its lens' free parameters, as calibrations report it
// (Calibration::claim, uncertain_camera in io/types.hpp).
struct UncertainCamera {
  const Model* model = nullptr;  // not owned; null: the lens is taken as exact
  Camera camera;
  MatrixX covariance;  // of the model's free parameters (k x k); empty: the lens is exact

  int num_free() const { return model ? model->num_free() : 0; }
  bool is_exact() const { return !model || covariance.size() == 0; }
  void check_covariance() const;  // throws Error unless it has the model's size, or is empty
};

// The standard deviation of each parameter of the lens: 0 for a held one, and where rounding made a
// variance negative.
std::vector<double> lens_sigmas(const UncertainCamera& known);

// The covariance of a lens by the free parameters of another model of its kind: each is the mean of
// the lens parameters that it sets; zero for parameters that the lens' own model holds.
MatrixX covariance_by(const Model& model, const UncertainCamera& known);

// Returns what keeps a square matrix from being a covariance, as in "must be symmetric, got 1 and
// 2"; "" if it is one: finite, symmetric and positive semi-definite, up to the rounding of numbers
// with six digits. Held and unknown combinations of parameters may make it singular.
std::string covariance_defect(const MatrixX& matrix);

struct UncertainPixel {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Matrix2 covariance_px2 = Matrix2::Zero();
};

// A point (metres), or the unit direction of a ray from the camera's centre, whose covariance has
// rank 2.
struct UncertainPoint {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// The pixel of a point in the camera frame; no value outside the lens' domain. Throws Error as
// UncertainCamera::check_covariance.
std::optional<UncertainPixel> project(const UncertainCamera& known,
                                      const UncertainPoint& in_camera);

// The direction of a pixel's ray in the camera frame; no value where the pixel has no ray. Throws
// Error for a parallel lens, whose rays have no common centre, and as above.
std::optional<UncertainPoint> direction(const UncertainCamera& known, const UncertainPixel& pixel);

// The point of a pixel at a depth (z in the camera frame, > 0), in the camera frame; no value if
// the ray does not point forward.
std::optional<UncertainPoint> point_at_depth(const UncertainCamera& known,
                                             const UncertainPixel& pixel, double depth_m,
                                             double sigma_depth_m = 0);

// The point of a pixel on the plane z = 0 of a frame, in that frame (the pose is exact); no value
// if the ray does not meet the plane in front of the camera.
std::optional<UncertainPoint> point_on_plane(const UncertainCamera& known,
                                             const UncertainPixel& pixel,
                                             const Pose& camera_from_plane);

}  // namespace tagcal
