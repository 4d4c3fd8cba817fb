#pragma once

#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::internal {

// Two cameras of a rig, and the joint covariance of the rig's parameters.
struct UncertainPair {
  const UncertainCamera &a, &b;
  Pose a_from_rig, b_from_rig;
  // The first of the parameters in `covariance`: of the places (six; none: exact), and of lenses.
  std::optional<Eigen::Index> place_a, place_b;
  Eigen::Index lens_a, lens_b;
  const Eigen::MatrixXd& covariance;         // whose last parameters are those of all lenses
  const Eigen::MatrixXd& inverse_of_lenses;  // of their covariance (inverse_of_last)
};

// The inverse of the last rows and columns of a covariance, where it is regular.
Eigen::MatrixXd inverse_of_last(const Eigen::MatrixXd& covariance, Eigen::Index size);

// The covariance of the pose of camera b in the frame of camera a (`retract`).
Matrix6 covariance_between(const Pose& a_from_rig, const Pose& b_from_rig,
                           std::optional<Eigen::Index> place_a, std::optional<Eigen::Index> place_b,
                           const Eigen::MatrixXd& covariance);

// Sets what places and lenses say of a pair: its pose, the baseline and the depths.
void report_place(const UncertainPair& pair, RigPair& result);

}  // namespace tagcal::internal
