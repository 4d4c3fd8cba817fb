#pragma once

#include <vector>

#include "study/atlas/stability.hpp"
#include "study/tasks/pose_error.hpp"

// What a pose that is answered, or refused, is worth. Private to study.

namespace tagcal::study {

// The square that a chi-square variable of `dof` degrees of freedom exceeds as rarely as a normal
// one is more than 5 sigma off: 25 of one, 39.5 of six, 41.7 of seven.
double five_sigma_square(int dof);

// Known well enough that it must not be refused: a standard deviation at the bound of less than
// 0.05 rad in every direction of rotation, and of 5 % of the distance; of pose with focal length,
// of 5 % of the focal length.
inline constexpr double kKnownShare = 0.05;
inline constexpr double kGrossRotationRad = 0.5235987755982988;  // 30 degrees
inline constexpr double kGrossFocalRatio = 1.5;
inline constexpr double kLeastPeerSigmaPx = 0.01;  // peers are not held to less noise than this

struct PoseQuestion {
  PoseTask task;
  std::vector<std::size_t> right;  // correspondences that are as the pose has them: the truth's
  bool focal = false;              // pose and focal length are asked for
  bool plane = false;              // may be flipped
  bool knowable = true;            // unless the bound says that it is not
  bool by_bound = false;           // ours is held to the bound as well, not to its covariance
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
  PoseTask truth_;  // the right points alone, about their centre
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  Eigen::MatrixXd information_;  // at the truth; empty: there is none
};

}  // namespace tagcal::study
