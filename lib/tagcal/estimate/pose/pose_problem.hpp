#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/pose/view_equations.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/solvers/numeric/inline_buffer.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"

namespace tagcal::internal {

// Where no noise is stated: it is estimated from residuals of at least so many degrees of freedom,
// else this is assumed.
inline constexpr int kEnoughDegreesOfFreedom = 50;
inline constexpr double kAssumedSigmaPx = 0.5;

// The correspondences of a view that an estimate uses, moved to the centre of the points and turned
// to their best plane: neither the place nor the attitude of the target in its own frame matters.
// Few enough (a tag) need no heap.
class PoseProblem {
 public:
  // Of the chosen correspondences (ascending), or of all. They and the options must outlive it.
  PoseProblem(std::span<const Correspondence> correspondences, const PoseOptions& options,
              std::span<const std::size_t> chosen = {});

  std::size_t size() const { return points_.size(); }
  bool finite() const { return finite_; }
  bool whitened() const { return !whitening_.empty(); }
  const PointSpread& spread() const { return spread_; }
  ViewPoints view() const { return {points_.span(), pixels_.span(), whitening_}; }

 private:
  InlineBuffer<Eigen::Vector3d, 8> points_;  // in the plane's frame
  InlineBuffer<Eigen::Vector2d, 8> pixels_;
  std::vector<Matrix2> whitening_;
  PointSpread spread_;
  bool finite_ = true;
};

// The noise that an estimate counts with.
struct NoiseLevel {
  double sigma_px = 1;
  bool known = false;    // stated, by sigma_px or by covariances
  bool assumed = false;  // neither known nor shown by the residuals
};
NoiseLevel noise_level(const PoseProblem& problem, const PoseOptions& options, double cost,
                       int num_parameters);

}  // namespace tagcal::internal
