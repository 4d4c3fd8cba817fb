#pragma once

#include <vector>

#include "study/atlas/stability.hpp"
#include "study/tasks/pose_error.hpp"

// Judges the answer, or the refusal, of a pose by the truth. Private to study.

namespace tagcal::study {

// The chi-square quantile with `dof` degrees of freedom for the probability that a normal variable
// is more than 5 sigma off: 25 for one, 39.5 for six, 41.7 for seven.
double five_sigma_square(int dof);

// A pose must not be refused if its Cramer-Rao bound is below these standard deviations: 0.05 rad
// in every direction of rotation and 5 % of the distance; for pose with focal length, 5 % of the
// focal length.
inline constexpr double kKnownShare = 0.05;
inline constexpr double kGrossRotationRad = 0.5235987755982988;  // 30 degrees
inline constexpr double kGrossFocalRatio = 1.5;
inline constexpr double kLeastPeerSigmaPx = 0.01;  // peers are not held to less noise than this

struct PoseQuestion {
  PoseTask task;
  std::vector<std::size_t> right;  // the correct correspondences
  bool focal = false;              // pose and focal length are estimated
  bool plane = false;              // may be flipped
  bool knowable = true;            // the bound must allow it as well
  bool by_bound = false;           // ours, too, is judged by the bound, not by its covariance
};

class PoseJudge {
 public:
  explicit PoseJudge(PoseQuestion question);

  StabilityVerdict judge(const PoseAnswer& answer) const;
  const PoseTask& task() const { return question_.task; }
  bool knowable() const { return question_.knowable; }

 private:
  bool known_by_bound() const;
  PoseAnswer about_centre(const PoseAnswer& answer) const;
  double bound_square(const PoseAnswer& centred) const;
  double claimed_square(const PoseAnswer& centred) const;
  bool in_front(const Pose& pose) const;
  bool gross(const PoseAnswer& centred) const;
  bool right_by_bound(const PoseAnswer& centred) const;
  bool right_by_claim(const PoseAnswer& centred) const;
  bool an_alternative_is_right(const PoseAnswer& centred) const;
  int dof() const { return question_.focal ? 7 : 6; }

  PoseQuestion question_;
  PoseTask truth_;  // only the correct points, relative to their centre
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  Eigen::MatrixXd information_;  // at the truth; empty: there is none
};

}  // namespace tagcal::study
