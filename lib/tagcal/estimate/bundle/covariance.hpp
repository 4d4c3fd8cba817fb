#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"

namespace tagcal::internal {

// The contribution of one view to the information of the parameters (those of the lens, then the
// shapes of the board) for (whitened) residuals of standard deviation 1. With A (by pose) and
// B (by parameters), the row terms eliminated, it is
//   S_v = B'B - B'A (A'A)^-1 A'B     (Triggs et al. 2000, section 6.1),
// and the gradient g_v of half the view's cost likewise.
struct ViewInformation {
  Eigen::MatrixXd schur;               // S_v
  Eigen::VectorXd gradient;            // g_v
  Matrix6 pose_inverse;                // (A'A)^-1
  Eigen::MatrixXd pose_by_parameters;  // (A'A)^-1 A'B
};

// No value if a point is outside the lens' domain or the view does not determine its pose.
std::optional<ViewInformation> information_of(const Bundle& bundle, std::size_t view,
                                              const Lens& lens);
// The same of a view alone, without the shapes of a board.
std::optional<ViewInformation> information_of(const ViewProblem& view, const Lens& lens,
                                              const Model& model, const Pose& camera_from_target,
                                              const ViewRowTerms& rows);

// The same from the products [J | r]'[J | r] (upper triangle) of rows by a pose (6) and by
// parameters. No value if they do not determine the pose.
std::optional<ViewInformation> eliminate_pose(const Eigen::MatrixXd& gram);

// The information of all views and of the pseudo-observations.
struct BundleInformation {
  std::vector<ViewInformation> views;
  // Numbers of the views' samples, which are independent: those of one pose are one sample
  // (pose_numbers). Empty: each view is a sample of its own.
  std::vector<std::size_t> sample;
  Eigen::MatrixXd prior;           // J'J of lens_prior and the board
  Eigen::VectorXd prior_gradient;  // J'r

  Eigen::MatrixXd data() const;                  // sum of S_v
  std::vector<ViewInformation> samples() const;  // S_v and g_v, summed by samples
  std::size_t num_samples() const;
  // H = data / sigma^2 + prior, for noise of this standard deviation.
  Eigen::MatrixXd total(double sigma) const;
  Eigen::VectorXd gradient(double sigma) const;
};
std::optional<BundleInformation> bundle_information(const Bundle& bundle,
                                                    std::size_t num_threads = 1);

// The covariance of a solved bundle.
struct BundleCovariance {
  Eigen::MatrixXd parameters;  // of the model's free parameters (k x k)
  Eigen::MatrixXd all;         // of these and the shapes of the board
  std::vector<Matrix6> poses;  // of each pose, (omega, tau): `retract`
  // Decrease of the cost by a Gauss-Newton step, over sigma^2. A large one means that the bundle is
  // at no minimum (policy::kExcludedCost).
  double decrement = 0;
  // Variance of the views' gradients over that of independent residuals (phi below).
  double overdispersion = 1;
};

// With A = H^-1 and M = the sum of S_v / sigma^2, the covariance of independent residuals is A =
// A M A + A P A: the data's part and the prior's. The residuals of a view share what the models of
// lens and board leave, and so do views of one pose, so the data's part comes from the spread
// between poses. S_v, g_v and V are here those of poses, the sums over their views:
//   spread     sum d_v d_v',  d_v = A (I - S_v A)^-1/2 g_v, in units of sigma: the sandwich of the
//              views' gradients, each corrected for its leverage (CR2: Bell & McCaffrey 2002);
//   scaled     phi A M A, with phi the overdispersion of the views' gradients, which few views do
//              not show: it is shrunk to `independent`, as if policy::kOverdispersionViews views
//              had shown that.
// The spread has V samples for n parameters, so it is shrunk to the scaled one as if
// policy::kSpreadViews views had shown that. `independent`: the overdispersion that neighbouring
// residuals and repeated poses suggest, >= 1 (expected_overdispersion). No value if H has no
// inverse.
std::optional<BundleCovariance> covariance_of(const Bundle& bundle,
                                              const BundleInformation& information, double sigma,
                                              double independent);
// The same for any parameters, of which `all` has the covariance, without poses. `prior_sigma`:
// the noise that weighed the priors of the solution.
std::optional<BundleCovariance> covariance_of(const BundleInformation& information, double sigma,
                                              double prior_sigma, double independent);

// Replaces the covariance of the parameters, and adds to that of the poses what follows.
void replace_covariance(BundleCovariance& covariance, const Eigen::MatrixXd& all,
                        const BundleInformation& information);

// The shape of the board, with its uncertainty. Precondition: the bundle has a board.
BoardWarp board_warp(const Bundle& bundle, const BundleCovariance& covariance);

// The standard deviation of the row terms (px a row) that the views show: the one of kRowSigmas, or
// 0, of the highest evidence, with lens and board held; the largest for fewer than
// policy::kFewestTellingViews views.
double row_sigma_of(const Bundle& solved, double sigma);

// The inverse of a symmetric positive definite matrix of any scale; no value if the matrix is
// singular up to rounding.
std::optional<Eigen::MatrixXd> exact_inverse(const Eigen::MatrixXd& information);

}  // namespace tagcal::internal
