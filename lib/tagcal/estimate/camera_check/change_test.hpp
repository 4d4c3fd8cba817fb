#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tagcal/estimate/camera_check/free_fit.hpp"

namespace tagcal::internal {

// The test of check_camera.hpp at the solution of a free fit, in coordinates in which the
// difference between the pictures and the known cameras has the covariance I: under a change d of
// the parameters its mean is `by_change` d.
class ChangeTest {
 public:
  ChangeTest(const FreeFit& fit, const KnownRig& known, const BundleInformation& information);

  // The change by a basis that explains the difference best, and what it explains of its square.
  struct Explained {
    double square = 0;
    Eigen::Index freedom = 0;      // the rank of the basis before the pictures
    Eigen::VectorXd coefficients;  // of the basis
    Eigen::MatrixXd covariance;
  };
  Explained explained_by(const Eigen::MatrixXd& basis) const;

  // The normal score of the difference that a change explains, and of what it leaves of the
  // whole difference.
  double score(double square, Eigen::Index freedom) const;
  double score() const { return score(all_.square, all_.freedom); }
  double rest(const Explained& part) const;

  // The change in the span of a basis that shows least, of those that move pixels by `rows` (by
  // the coefficients of the basis), with the size at which it is found.
  Eigen::VectorXd least_shown(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& rows) const;

 private:
  double freedom_ = 0;  // of the noise
  Eigen::VectorXd difference_;
  Eigen::MatrixXd by_change_;
  Explained all_;
};

}  // namespace tagcal::internal
