#include "tagcal/estimate/checks/lack_of_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/checks/split_half_check.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

std::string bend_text(const BoardWarp& warp) {
  return number(warp.bend_mm.x()) + " mm along x and " + number(warp.bend_mm.y()) + " mm along y";
}

std::string cause(const LackOfFit& evidence, const char* of_board) {
  return "the model is too small" +
         (evidence.small_model ? std::string() : ", or the board is " + std::string(of_board)) +
         "; all standard deviations are multiplied by " + number(std::sqrt(evidence.inflation()));
}

// Chi-square of the bend, in units of sigma_with_floor.
double bend_chi_square(const BoardWarp& warp, const Calibration& c,
                       const CalibrateOptions& options) {
  const double share = c.sigma_px / sigma_with_floor(c, options);
  return share * share * warp.chi_square;
}

// Returns true if a larger lens explains more than a bent board would. Adds the finding only for a
// model asked for by name: `auto` has compared the larger models itself.
bool is_small_model(Calibration& c, const LackOfFit& evidence, double bent,
                    const CalibrateOptions& options) {
  const auto larger = larger_lens(*evidence.bundle, sigma_with_floor(c, options));
  if (!larger || larger->chi_square < std::max(policy::kSmallModelChiSquare, bent)) return false;
  if (!is_auto(options))
    add(c.findings, code::model_too_small,
        "the model is too small: opencv5 would explain " + percent(larger->share) +
            " of the sum of its squared residuals; take opencv5 or auto");
  return true;
}

}  // namespace

double sigma_with_floor(const Calibration& c, const CalibrateOptions& options) {
  return std::max(c.sigma_px, least_sigma(c.sigma_of_corners, options));
}

bool warn_of_impossible_bend(Calibration& c, const BoardWarp& warp, const FlatBoard& board) {
  const double largest_mm = policy::kLargestBoardBend * 2e3 * board.half_size.norm();
  if (warp.bend_mm.cwiseAbs().maxCoeff() <= largest_mm) return false;
  add(c.findings, code::board_bend_impossible,
      "the corners fit a board bent by " + bend_text(warp) +
          ", more than a board can bend: the model is too small, or the target is not "
          "as its file says");
  return true;
}

void judge_model_and_board(Calibration& c, LackOfFit& evidence, const CalibrateOptions& options) {
  std::optional<BoardWarp> warp;
  if (evidence.board && evidence.information)
    warp = board_warp(*evidence.bundle, *evidence.information, c.sigma_px);
  const double bent = warp && !options.board_warp ? bend_chi_square(*warp, c, options) : 0;
  evidence.small_model = is_small_model(c, evidence, bent, options);
  if (options.board_warp) {
    c.board_warp = warp;
    if (warp) warn_of_impossible_bend(c, *warp, *evidence.board);
  } else if (bent > policy::kBentBoardChiSquare && !evidence.small_model &&
             !warn_of_impossible_bend(c, *warp, *evidence.board)) {
    evidence.bent = true;
    add(c.findings, code::board_bent,
        "the corners fit a bent board better, by " + bend_text(*warp) +
            ": try --board-warp, or a larger model; the standard deviations include "
            "what the bend changes");
  }
}

double LackOfFit::inflation() const {
  const double by_halves = halves && halves->disagree ? halves->ratio * halves->ratio : 1;
  return std::max(field.inflation, by_halves);
}

void compare_residuals(const Calibration& c, LackOfFit& evidence, const CalibrateOptions& options) {
  const Bundle& bundle = *evidence.bundle;
  evidence.field = residual_bias(bundle, least_sigma(c.sigma_of_corners, options));
  if (evidence.information)
    evidence.halves = split_half_check(bundle, *evidence.information, sigma_with_floor(c, options),
                                       seen_region(bundle).samples(), median_distance_m(bundle));
}

void add_bend(BundleCovariance& covariance, const LackOfFit& evidence, double sigma) {
  if (!evidence.bent) return;
  const BundleInformation& information = *evidence.information;
  const auto inverse = exact_inverse(information.halves[0] + information.halves[1]);
  if (!inverse) return;
  const Eigen::Index k = covariance.parameters.cols();
  const Eigen::VectorXd gradient = information.gradients[0] + information.gradients[1];
  const Eigen::Vector2d bend = (*inverse * gradient).tail<2>();
  // A change of the bend changes the parameters by C_pb C_bb^-1.
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

void warn_of_lack_of_fit(Calibration& c, const LackOfFit& evidence) {
  if (evidence.field.disagree)
    add(c.findings, code::residuals_biased,
        "the residuals differ from place to place in the image, by " +
            number(evidence.field.rms_px) + " px RMS: " + cause(evidence, "bent"));
  c.halves = evidence.halves;
  if (c.halves && c.halves->disagree)
    add(c.findings, code::halves_disagree,
        "two halves of the views disagree (difference " + percent(c.halves->ratio) +
            " of the expected noise): " + cause(evidence, "bent or moved"));
}

}  // namespace tagcal::internal
