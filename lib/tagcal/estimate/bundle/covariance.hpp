#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// The covariance of a solved bundle for noise of standard deviation sigma per (whitened)
// coordinate, from the exact inverse of the information: no pseudo-inverse, no prior.
struct BundleCovariance {
  Eigen::MatrixXd parameters;  // of the model's free parameters (k x k)
  std::vector<Matrix6> poses;  // of each pose, (omega, tau): `retract`
  // Decrease of the cost by a Gauss-Newton step, over sigma^2; 0 with unobservable coefficients. A
  // large one means that the bundle is at no minimum (policy::kLargestDecrement).
  double decrement = 0;
};

// The information of the free parameters for whitened residuals of standard deviation 1 and unknown
// poses, as the sums over two halves: views of even and of odd number. The two bends of a board are
// the last parameters: of the bundle's, else of `held_flat`, whose bends are not estimated.
struct BundleInformation {
  Eigen::MatrixXd sum() const { return halves[0] + halves[1]; }
  Eigen::VectorXd gradient() const { return gradients[0] + gradients[1]; }
  // Gives parameters that the data do not determine a large standard deviation, so that the
  // information has an inverse (policy::kUnobservablePrecision).
  void raise_unobservable();

  std::array<Eigen::MatrixXd, 2> halves;            // S of each half
  std::array<Eigen::VectorXd, 2> gradients;         // of half the cost
  std::vector<Matrix6> pose_inverse;                // (A'A)^-1 per view
  std::vector<Eigen::MatrixXd> pose_by_parameters;  // (A'A)^-1 A'B per view
};
std::optional<BundleInformation> bundle_information(const Bundle& bundle,
                                                    const FlatBoard* held_flat = nullptr);

// With A (by pose) and B (by parameters) per view, the information of the parameters is
// S = sum(B'B - B'A (A'A)^-1 A'B), and the covariance of a pose is (A'A)^-1 + M S^-1 M' with
// M = (A'A)^-1 A'B, times sigma^2 (Triggs et al. 2000, section 6.1). No value if S, scaled to a
// unit diagonal, has no inverse.
std::optional<BundleCovariance> covariance_of(const Bundle& bundle, double sigma);
std::optional<BundleCovariance> covariance_of(const Bundle& bundle,
                                              const BundleInformation& information, double sigma);

// The covariance of a bundle's parameters, widened by the profile likelihood
// (profile_likelihood.hpp) of the least known of focal length and principal point, to either side.
// Focal length, principal point and poses are correlated along a curve, a bent valley of the cost,
// of which the information describes the tangent only. `information` is that of the solved bundle,
// `covariance` that of its parameters for noise of `sigma`. Not widened if the parameters are well
// determined (policy::kLinearShare).
Eigen::MatrixXd profile_covariance(const Bundle& solved, const BundleInformation& information,
                                   const Eigen::MatrixXd& covariance, double sigma);

// The bend of the board, with its uncertainty: that of the bundle, after a Gauss-Newton step of all
// parameters. A flat board that is held gets the bend that the residuals show. `information`
// includes the bends. No value if they are not determined.
std::optional<BoardWarp> board_warp(const Bundle& bundle, const BundleInformation& information,
                                    double sigma);

// The contribution of one view to the sums above: information of the free parameters (and of two
// bends, with a board) for whitened residuals of standard deviation 1 and an unknown pose. No value
// if a point is outside the lens' domain or the view does not determine its pose.
struct ViewInformation {
  Eigen::MatrixXd schur;               // its part of S
  Eigen::VectorXd gradient;            // of half its cost
  Matrix6 pose_inverse;                // (A'A)^-1
  Eigen::MatrixXd pose_by_parameters;  // (A'A)^-1 A'B
};
std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              std::span<const FreeParameter> free,
                                              const Pose& camera_from_target,
                                              const FlatBoard* board = nullptr);

// The inverse of a symmetric positive definite matrix of any scale; no value if the matrix is
// singular up to rounding.
std::optional<Eigen::MatrixXd> exact_inverse(const Eigen::MatrixXd& information);

// Standard deviation (px per coordinate) of the projection of infinitely far points, less the part
// that a rotation of the camera explains: RMS over the pixels of the corners, of at most 1,000 of
// them. This decides whether the intrinsics are determined, not the deviation of single parameters.
double projection_sigma_at_infinity_px(const Bundle& bundle, const Eigen::MatrixXd& covariance);

}  // namespace tagcal::internal
