#include "tagcal/estimate/pose/pose_problem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/solvers/solutions.hpp"

namespace tagcal::internal {
namespace {

bool is_covariance(const Matrix2& c) {
  constexpr double kRounding = 1e-12;  // numeric: rounding of the determinant
  const double product = c(0, 0) * c(1, 1);
  return c.allFinite() && c(0, 0) > 0 && c(1, 1) > 0 && std::isfinite(product) &&
         c(0, 1) == c(1, 0) && product - c(0, 1) * c(1, 0) > kRounding * product;
}

// True if four of the points are distinct.
bool has_four_places(const PoseProblem& problem) {
  const std::span<const Eigen::Vector3d> points = problem.view().points;
  const double apart = 1e-9 * problem.spread().size;  // numeric: rounding of equal points
  Solutions<Eigen::Vector3d, 4> places;
  for (std::size_t i = 0; i < points.size() && !places.full(); ++i)
    if (std::none_of(places.begin(), places.end(), [&](const Eigen::Vector3d& p) {
          return (points[i] - p).squaredNorm() <= apart * apart;
        }))
      places.push_back(points[i]);
  return places.full();
}

}  // namespace

PoseProblem::PoseProblem(std::span<const Correspondence> correspondences,
                         const PoseOptions& options, const std::optional<Indices>& chosen)
    : points_(chosen ? chosen->size() : correspondences.size()), pixels_(points_.size()) {
  const auto index = [&](std::size_t i) { return chosen ? (*chosen)[i] : i; };
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

std::string defect(const PoseOptions& options, std::size_t num_points) {
  const double variance = options.sigma_px * options.sigma_px;
  const bool in_range = variance >= std::numeric_limits<double>::min() && std::isfinite(variance);
  if (options.sigma_px != 0 && !(options.sigma_px > 0 && in_range))
    return fmt::format("the noise must be > 0, or 0 if it is not known, got {} px",
                       options.sigma_px);
  const std::span<const Matrix2> covariances = options.covariance_px2;
  if (!covariances.empty() && covariances.size() != num_points)
    return fmt::format("{} covariances for {} points", covariances.size(), num_points);
  if (!options.groups.empty() && options.groups.size() != num_points)
    return fmt::format("{} groups for {} points", options.groups.size(), num_points);
  const auto bad = std::find_if_not(covariances.begin(), covariances.end(), is_covariance);
  if (bad != covariances.end())
    return fmt::format("covariance {} is not positive definite", bad - covariances.begin());
  return {};
}

std::string defect(const PoseProblem& problem) {
  if (!problem.finite()) return "a point or a pixel is not finite";
  if (problem.size() < 4)
    return fmt::format("too few points: 4 are needed, got {}", problem.size());
  const PointShape shape = problem.spread().shape;
  if (shape == PointShape::point) return "all points coincide";
  if (shape == PointShape::line) return "the points lie on a line";
  if (!has_four_places(problem))
    return "too few points: 4 different ones are needed, the others are duplicates";
  return {};
}

NoiseLevel noise_level(const PoseProblem& problem, const PoseOptions& options, double cost,
                       int num_parameters) {
  if (problem.whitened()) return {1, true, false};
  if (options.sigma_px > 0) return {options.sigma_px, true, false};
  const int freedom = 2 * static_cast<int>(problem.size()) - num_parameters;
  if (freedom >= policy::kEnoughDegreesOfFreedom)
    return {std::max(kLeastPoseSigmaPx, std::sqrt(cost / freedom)), false, false};
  return {policy::kAssumedSigmaPx, false, true};
}

}  // namespace tagcal::internal
