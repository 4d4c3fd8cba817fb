#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/estimate/pose/view_equations.hpp"
#include "tagcal/estimate/types.hpp"
#include "tagcal/internal/shared_vector.hpp"

namespace tagcal::internal {

// One view for the solvers: correspondences and, if corners have a known covariance C, the matrices
// W with W^T W = C^-1 that whiten their residuals (if empty: the identity).
struct ViewProblem {
  SharedVector<Correspondence> correspondences;
  SharedVector<Matrix2> whitening;  // empty, or one per correspondence
};

// Arrays of a view's correspondences for the kernels. The view must outlive it.
class ViewArrays {
 public:
  explicit ViewArrays(const ViewProblem& view);
  ViewPoints view() const { return {points_, pixels_, whitening_}; }
  std::span<Eigen::Vector3d> points() { return points_; }
  // Moves the points by the shapes of their board.
  void displace(const ViewShapes& shapes, const Eigen::Vector4d& by);
  // Moves each point by the velocity (omega, tau) a row of its board, which stands still at
  // `middle_row`.
  void move_rows(const Vector6d& velocity_in_target, double middle_row);

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<Eigen::Vector2d> pixels_;
  std::span<const Matrix2> whitening_;
};

// Returns W with W^T W = covariance^-1. The covariance must be positive definite.
Matrix2 whitening_of(const Matrix2& covariance_px2);

// Residuals (2n: projected - observed) of a view, with Jacobians by (omega, tau) of `retract`
// (2n x 6) and by a model's free parameters (2n x k), all whitened. No value if a point is
// outside the lens' domain.
struct Reprojection {
  Eigen::VectorXd residuals;
  RowMajor6 by_pose;
  RowMajorX by_parameters;
};
std::optional<Reprojection> reprojection(const ViewProblem& view, const Lens& lens,
                                         std::span<const FreeParameter> free,
                                         const Pose& camera_from_target);

// Squared whitened lengths of the residuals of a view's corners; infinite if not finite.
std::vector<double> whitened_squares(const ViewProblem& view, const Lens& lens,
                                     const Pose& camera_from_target);

// Returns the corners of a view whose number in `takes_part` is 1.
ViewProblem chosen(const ViewProblem& view, std::span<const std::uint8_t> takes_part);

// The correspondences that are not outliers (ascending), with a noise of 1: whitened by sigma_px
// and by their covariances, if they have any, which sigma_px raises (PoseEstimate::sigma_px).
ViewProblem inlier_view(std::span<const Correspondence> correspondences,
                        std::span<const Matrix2> covariance_px2,
                        std::span<const std::size_t> outliers, double sigma_px);

// Residuals in pixels, not whitened; NaN for points outside the lens' domain.
std::vector<Eigen::Vector2d> residuals_px(std::span<const Correspondence> correspondences,
                                          const Lens& lens, const Pose& camera_from_target);

}  // namespace tagcal::internal
