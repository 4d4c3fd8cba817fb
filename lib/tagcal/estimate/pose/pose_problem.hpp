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

// The correspondences of a view that an estimate uses, moved to the centre of the points and turned
// to their best plane, so that the answer does not depend on the target's frame. A tag needs no
// heap.
class PoseProblem {
 public:
  using Indices = std::span<const std::size_t>;

  // Uses the chosen correspondences (ascending; there may be none), or all if nothing is chosen
  // from. They and the options must outlive it.
  PoseProblem(std::span<const Correspondence> correspondences, const PoseOptions& options,
              const std::optional<Indices>& chosen = std::nullopt);

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

// Describes an invalid option; empty if all are valid.
std::string defect(const PoseOptions& options, std::size_t num_points);

// Describes why a problem has no answer; empty if it may have one.
std::string defect(const PoseProblem& problem);

// px. Floor of the noise that residuals show: what rounding leaves of exact pixels is no noise, and
// failed the test of residuals in 3 % of exact views.
constexpr double kLeastPoseSigmaPx = 1e-6;  // numeric: rounding

// The noise that an estimate assumes.
struct NoiseLevel {
  double sigma_px = 1;
  bool known = false;    // stated, by sigma_px or by covariances
  bool assumed = false;  // neither stated nor estimated from the residuals
};
NoiseLevel noise_level(const PoseProblem& problem, const PoseOptions& options, double cost,
                       int num_parameters);

}  // namespace tagcal::internal
