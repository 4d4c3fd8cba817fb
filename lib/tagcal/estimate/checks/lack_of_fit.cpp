#include "tagcal/estimate/checks/lack_of_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/board_warp.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/checks/split_half_check.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

constexpr double kBentChiSquare = 18.4;      // two degrees of freedom, p = 0.0001
constexpr double kSmallModelChiSquare = 45;  // eight degrees of freedom at most, p = 4e-7
constexpr double kLargestBend = 0.01;        // of a board's diagonal

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

std::string bend_text(const BoardWarp& warp) {
  return number(warp.bend_mm.x()) + " mm along x and " + number(warp.bend_mm.y()) + " mm along y";
}

std::string cause(const MisfitEvidence& evidence, const char* of_board) {
  return "the model is too small" +
         (evidence.small_model ? std::string() : ", or the board is " + std::string(of_board)) +
         "; the standard deviations are " + number(std::sqrt(evidence.inflation())) +
         " times as large for it";
}

// In units of the noise that counts.
double chi_square(const BoardWarp& warp, const Calibration& c, const CalibrateOptions& options) {
  const double share = c.sigma_px / sigma_that_counts(c, options);
  return share * share * warp.chi_square;
}

// A larger lens explains more than a bent board would. No word of it where `auto` has asked the
// larger models itself, and the smaller one stands for them.
bool is_small_model(Calibration& c, const MisfitEvidence& evidence, double bent,
                    const CalibrateOptions& options) {
  const auto larger = larger_lens(*evidence.bundle, sigma_that_counts(c, options));
  if (!larger || larger->chi_square < std::max(kSmallModelChiSquare, bent)) return false;
  if (!options.model.empty() && options.model != "auto")
    c.warnings.push_back("the model is too small: opencv5 would explain " + percent(larger->share) +
                         " of the squares of its residuals");
  return true;
}

}  // namespace

double sigma_that_counts(const Calibration& c, const CalibrateOptions& options) {
  return std::max(c.sigma_px, least_sigma(c.sigma_of_corners, options));
}

bool warn_of_impossible_bend(Calibration& c, const BoardWarp& warp, const FlatBoard& board) {
  const double largest_mm = kLargestBend * 2e3 * board.half_size.norm();
  if (warp.bend_mm.cwiseAbs().maxCoeff() <= largest_mm) return false;
  c.warnings.push_back("the corners ask for a board bent by " + bend_text(warp) +
                       ", more than a board can be: the model is too small, or the target is not "
                       "as its file says");
  return true;
}

void judge_model_and_board(Calibration& c, MisfitEvidence& evidence,
                           const CalibrateOptions& options) {
  std::optional<BoardWarp> warp;
  if (evidence.board && evidence.information)
    warp = estimate_warp(*evidence.information, c.sigma_px);
  const double bent = warp ? chi_square(*warp, c, options) : 0;
  evidence.small_model = is_small_model(c, evidence, bent, options);
  if (options.board_warp) {
    c.board_warp = warp;
  } else if (bent > kBentChiSquare && !evidence.small_model &&
             !warn_of_impossible_bend(c, *warp, *evidence.board)) {
    evidence.bent = true;
    c.warnings.push_back("the corners fit a bent board better, by " + bend_text(*warp) +
                         ": try --board-warp, or a larger model; what it changes counts in the "
                         "standard deviations");
  }
}

double MisfitEvidence::inflation() const {
  const double of_halves = halves && halves->disagree ? halves->ratio * halves->ratio : 1;
  return std::max(field.inflation, of_halves);
}

void compare_residuals(const Calibration& c, MisfitEvidence& evidence,
                       const CalibrateOptions& options) {
  const Bundle& bundle = *evidence.bundle;
  evidence.field = residual_field(bundle, least_sigma(c.sigma_of_corners, options));
  if (evidence.information)
    evidence.halves = compare_halves(bundle, *evidence.information, sigma_that_counts(c, options),
                                     seen_region(bundle).samples(), median_distance_m(bundle));
}

void count_bend(BundleCovariance& covariance, const MisfitEvidence& evidence, double sigma) {
  if (!evidence.bent) return;
  const BundleInformation& information = *evidence.information;
  const auto inverse = exact_inverse(information.halves[0] + information.halves[1]);
  if (!inverse) return;
  const Eigen::Index k = covariance.parameters.cols();
  const Eigen::VectorXd gradient = information.gradients[0] + information.gradients[1];
  const Eigen::Vector2d bend = (*inverse * gradient).tail<2>();
  // The parameters answer to the bend by C_pb C_bb^-1.
  const Eigen::MatrixXd by_bend =
      inverse->topRightCorner(k, 2) * inverse->bottomRightCorner<2, 2>().inverse();
  const Eigen::Matrix2d open =
      sigma * sigma * evidence.inflation() * inverse->bottomRightCorner<2, 2>() +
      bend * bend.transpose();
  const Eigen::MatrixXd more = by_bend * open * by_bend.transpose();
  covariance.parameters += more;
  for (std::size_t v = 0; v < covariance.poses.size(); ++v) {
    const auto by_parameters = information.pose_by_parameters[v].leftCols(k);
    covariance.poses[v] += by_parameters * more * by_parameters.transpose();
  }
}

void warn_of_misfit(Calibration& c, const MisfitEvidence& evidence) {
  if (evidence.field.disagree)
    c.warnings.push_back("the residuals differ from place to place in the image, by " +
                         number(evidence.field.rms_px) + " px RMS: " + cause(evidence, "bent"));
  c.halves = evidence.halves;
  if (c.halves && c.halves->disagree)
    c.warnings.push_back("two halves of the views differ by " + percent(c.halves->ratio) +
                         " of what their noise explains: " + cause(evidence, "bent or moved"));
}

}  // namespace tagcal::internal
