#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal {

// Cameras at known places on one body.
struct KnownRig {
  struct Member {
    std::string name;
    UncertainCamera camera;
    Pose camera_from_rig;
    // Error of a projection besides the corners' noise (CalibrationFile::camera_error_px).
    std::optional<double> camera_error_px;
  };
  std::vector<Member> cameras;
  // Of (omega rad, tau m) of all camera_from_rig in turn (`retract`), then of the free parameters
  // of all lenses (none without a model). Empty: places and lenses are taken as exact.
  MatrixX covariance;

  // The first of the free parameters of a camera's lens in `covariance`; of one past the last
  // camera its size.
  Eigen::Index first_of_lens(std::size_t camera) const;
  // The camera whose frame is that of the rig.
  std::optional<std::size_t> reference() const;
  // Sets `covariance` from one as of RigCalibration, without the places of the reference, and of
  // boards or not. Precondition: there is a reference, and the size fits.
  void set_joint_covariance(const MatrixX& joint);
  // Throws Error unless `covariance` is empty or of its size.
  void check_covariance() const;
};

// The step of b_from_a = b_from_rig * a_from_rig^-1 by those of the two poses (`retract`).
Eigen::Matrix<double, 6, 12> pair_by_places(const Pose& a_from_rig, const Pose& b_from_rig);

// How unlike zero a step d of covariance C is, as the quantile of a normal distribution: of d' C^-1
// d over the directions that have a variance (rounding leaves some without). No value if a
// component has none.
std::optional<double> step_score(const Eigen::VectorXd& step, const MatrixX& covariance);

// Some cameras of a rig, in this order, with the covariance of these.
KnownRig selected(const KnownRig& rig, std::span<const std::size_t> cameras);

}  // namespace tagcal
