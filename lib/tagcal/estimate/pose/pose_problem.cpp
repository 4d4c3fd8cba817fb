#include "tagcal/estimate/pose/pose_problem.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"

namespace tagcal::internal {

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

NoiseLevel noise_level(const PoseProblem& problem, const PoseOptions& options, double cost,
                       int num_parameters) {
  if (problem.whitened()) return {1, true, false};
  if (options.sigma_px > 0) return {options.sigma_px, true, false};
  const int freedom = 2 * static_cast<int>(problem.size()) - num_parameters;
  if (freedom >= policy::kEnoughDegreesOfFreedom)
    return {std::max(policy::kLeastPoseSigmaPx, std::sqrt(cost / freedom)), false, false};
  return {policy::kAssumedSigmaPx, false, true};
}

}  // namespace tagcal::internal
