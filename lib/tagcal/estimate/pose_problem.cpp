#include "tagcal/estimate/pose_problem.hpp"

#include <cmath>

#include "tagcal/estimate/reprojection.hpp"

namespace tagcal {
namespace {

constexpr double kAssumedSigmaPx = 0.5;
constexpr int kEnoughDegreesOfFreedom = 50;

}  // namespace

PoseProblem::PoseProblem(std::span<const Correspondence> correspondences,
                         const PoseOptions& options, std::span<const std::size_t> chosen)
    : points_(chosen.empty() ? correspondences.size() : chosen.size()), pixels_(points_.size()) {
  const auto index = [&](std::size_t i) { return chosen.empty() ? i : chosen[i]; };
  for (std::size_t i = 0; i < size(); ++i) {
    const Correspondence& c = correspondences[index(i)];
    points_[i] = c.point;
    pixels_[i] = c.pixel;
    finite_ = finite_ && c.point.allFinite() && c.pixel.allFinite();
  }
  if (!options.covariance_px2.empty())
    for (std::size_t i = 0; i < size(); ++i)
      whitening_.push_back(whitening_of(options.covariance_px2[index(i)]));
  if (!finite_) return;
  spread_ = spread_of(points_.span());
  for (std::size_t i = 0; i < size(); ++i) points_[i] = spread_.in_plane(points_[i]);
}

PoseHypothesis PoseProblem::in_target_frame(const PoseHypothesis& of_plane) const {
  PoseHypothesis result = of_plane;
  result.camera_from_target = of_plane.camera_from_target * spread_.plane_from_target_pose();
  change_origin(result.camera_from_target.translation() - of_plane.camera_from_target.translation(),
                result.covariance);
  return result;
}

NoiseLevel noise_level(const PoseProblem& problem, const PoseOptions& options, double cost,
                       int num_parameters) {
  if (problem.whitened()) return {1, true, false};
  if (options.sigma_px > 0) return {options.sigma_px, true, false};
  const int freedom = 2 * static_cast<int>(problem.size()) - num_parameters;
  if (freedom >= kEnoughDegreesOfFreedom) return {std::sqrt(cost / freedom), false, false};
  return {kAssumedSigmaPx, false, true};
}

// The other origin moves by tau - [from_origin] omega.
void change_origin(const Eigen::Vector3d& from_origin, Matrix6& covariance) {
  if (from_origin.isZero(0)) return;
  const Eigen::Matrix3d a = -cross_matrix(from_origin);
  const Eigen::Matrix3d turn = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d moved = covariance.topRightCorner<3, 3>() + turn * a.transpose();
  const Eigen::Matrix3d old = covariance.topRightCorner<3, 3>();
  covariance.bottomRightCorner<3, 3>() += (a * moved + old.transpose() * a.transpose()).eval();
  covariance.topRightCorner<3, 3>() = moved;
  covariance.bottomLeftCorner<3, 3>() = moved.transpose();
}

}  // namespace tagcal
