#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/estimate/bundle/flat_board.hpp"

namespace tagcal::internal {

// The covariance of a solved bundle for noise of one standard deviation sigma per (whitened)
// coordinate, from the exact inverse of the information: no pseudo-inverse, no prior.
struct BundleCovariance {
  Eigen::MatrixXd parameters;  // of the free parameters (k x k)
  std::vector<Matrix6> poses;  // of each pose, (omega, tau): `retract`
};

// The information of the free parameters for whitened residuals of standard deviation 1, poses left
// open, in two halves: every other view, and the rest. With a board its two bends follow the
// parameters.
struct BundleInformation {
  std::array<Eigen::MatrixXd, 2> halves;            // S of each half
  std::array<Eigen::VectorXd, 2> gradients;         // of half the cost
  std::vector<Matrix6> pose_inverse;                // (A'A)^-1 per view
  std::vector<Eigen::MatrixXd> pose_by_parameters;  // (A'A)^-1 A'B per view
};
std::optional<BundleInformation> bundle_information(const Bundle& bundle,
                                                    const FlatBoard* board = nullptr);

// With A (by pose) and B (by parameters) per view, the information of the parameters is
// S = sum(B'B - B'A (A'A)^-1 A'B), and a pose adds its own to what the parameters leave open
// (Triggs et al. 2000, section 6.1). No value where S, scaled to a unit diagonal, has no inverse.
std::optional<BundleCovariance> covariance_of(const Bundle& bundle, double sigma);

// The same of the first k parameters of an information: a bend is held, or the last two of them.
std::optional<BundleCovariance> covariance_of(const BundleInformation& information, Eigen::Index k,
                                              double sigma);

// What one view says of the free parameters (and of two bends, with a board) for whitened residuals
// of standard deviation 1, its own pose left open: its parts of the above. No value where a point
// is outside the lens' domain or the view does not determine its pose.
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

// The inverse of a symmetric positive definite matrix of any scale; no value where rounding could
// have made it up.
std::optional<Eigen::MatrixXd> exact_inverse(const Eigen::MatrixXd& information);

// How far the projection of infinitely far points is uncertain, in pixels, with the part that a
// turned camera explains taken out: RMS over the pixels at which corners were seen, 1,000 of them
// at most (per coordinate). This, not any single parameter's deviation, says whether the intrinsics
// are known.
double projection_sigma_at_infinity_px(const Bundle& bundle, const Eigen::MatrixXd& covariance);

}  // namespace tagcal::internal
