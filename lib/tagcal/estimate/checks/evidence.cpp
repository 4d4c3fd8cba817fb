#include "tagcal/estimate/checks/evidence.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/projection_uncertainty.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// Adds a covariance of the parameters, and what it changes in the poses.
void add_to_covariance(BundleCovariance& covariance, const BundleInformation& information,
                       const Eigen::MatrixXd& more) {
  covariance.parameters += more;
  for (std::size_t v = 0; v < covariance.poses.size(); ++v) {
    const auto by_parameters = information.pose_by_parameters[v].leftCols(more.cols());
    covariance.poses[v] += by_parameters * more * by_parameters.transpose();
  }
}

// Widens the covariance of weakly determined parameters by their profile likelihood.
void widen_by_profile(Evidence& evidence, const Bundle& bundle) {
  Observability& seen = evidence.observability;
  if (seen.status != Status::ok || !seen.open.empty()) return;
  const Eigen::MatrixXd widened = profile_covariance(bundle, *evidence.information,
                                                     seen.covariance->parameters, evidence.sigma);
  add_to_covariance(*seen.covariance, *evidence.information, widened - seen.covariance->parameters);
}

// Adds the effect of a free bend to the covariance of a flat board that the residuals contradict:
// the variance of the bend and the square of its estimate.
void widen_by_bend(Evidence& evidence) {
  const auto inverse = exact_inverse(evidence.information->sum());
  if (!inverse) return;
  BundleCovariance& covariance = *evidence.observability.covariance;
  const Eigen::Index k = covariance.parameters.cols();
  const Eigen::Vector2d bend = evidence.bend->bend_mm / 1e3;
  // A change of the bend changes the parameters by C_pb C_bb^-1.
  const Eigen::MatrixXd by_bend =
      inverse->topRightCorner(k, 2) * inverse->bottomRightCorner<2, 2>().inverse();
  const Eigen::Matrix2d open =
      evidence.sigma * evidence.sigma * evidence.inflation() * inverse->bottomRightCorner<2, 2>() +
      bend * bend.transpose();
  add_to_covariance(covariance, *evidence.information, by_bend * open * by_bend.transpose());
}

void widen_by_lack_of_fit(Evidence& evidence, const Solution& solution) {
  const Bundle& bundle = solution.fit->bundle;
  Observability& seen = evidence.observability;
  BundleCovariance& covariance = *seen.covariance;
  covariance.parameters *= evidence.inflation();
  for (Matrix6& pose : covariance.poses) pose *= evidence.inflation();
  if (evidence.is_board_bent() && !is_impossible(*evidence.bend, *solution.board))
    widen_by_bend(evidence);
  if (seen.status == Status::ok) judge_focal_length(seen, bundle);
  evidence.model_covariance = covariance.parameters;
  add_model_uncertainty(covariance, bundle, solution.fit->views, solution.supported);
  // Another model that does not determine the focal length widens the covariance only; it does not
  // refuse the answer.
  seen.focal_share = relative_focal_sigma(bundle, covariance.parameters);
}

void find_lack_of_fit(Evidence& evidence, const Solution& solution) {
  const Bundle& bundle = solution.fit->bundle;
  evidence.bias = residual_bias(bundle, least_sigma(solution.fit->whitened, *solution.options));
  evidence.halves = split_half_check(bundle, *evidence.information, evidence.floored_sigma,
                                     evidence.seen.samples(), evidence.distance_m);
  evidence.larger = larger_lens(bundle, evidence.floored_sigma);
  if (!solution.board) return;
  evidence.bend = board_warp(bundle, *evidence.information, evidence.sigma);
  const double share = evidence.sigma / evidence.floored_sigma;
  if (evidence.bend && !solution.options->board_warp)
    evidence.bend_chi_square = share * share * evidence.bend->chi_square;
}

// Tests for a target that is not as its file says: a corner's residuals then have the same
// direction on the board in all views. No test if a larger lens explains more of the residuals, or
// if the fit is no minimum. A refused focal length may be the consequence of a wrong target.
std::optional<TargetError> find_target_error(const Evidence& evidence, const Solution& solution) {
  const Status seen = evidence.observability.status;
  if (!(seen == Status::ok && evidence.at_minimum) && seen != Status::focal_not_observable)
    return std::nullopt;
  auto error = target_error(*solution.input, *solution.fit, solution.board);
  if (error && evidence.larger &&
      evidence.larger->share > std::max(error->share, policy::kLargerLensShare))
    return std::nullopt;
  return error;
}

// Largest standard deviation of the projection at infinity over the corners of the image that the
// lens sees.
double worst_corner_px(const UncertainLens& lens, const ImageSize& size,
                       std::span<const Eigen::Vector2d> samples) {
  double worst = 0;
  const ProjectionUncertainty known =
      projection_uncertainty(lens, {size, 2, 2}, samples, kInfinitelyFar);
  for (const double sigma : known.sigma_px.reshaped())
    if (sigma > worst) worst = sigma;
  return worst;
}

std::string px(double value) { return with_digits(value, 2) + " px"; }

}  // namespace

bool Evidence::is_model_small() const {
  // opencv5 has at most eight parameters more.
  const double by_chance = chi_square_quantile(8, policy::kOutlierSigmas);
  return larger && larger->chi_square >= std::max(by_chance, bend_chi_square);
}

bool Evidence::is_board_bent() const {
  // A chi-square of two degrees of freedom exceeds x with the probability exp(-x / 2).
  const double p = std::erfc(policy::kSignificant / std::numbers::sqrt2) / 2;
  return bend_chi_square > -2 * std::log(p) && !is_model_small();
}

double Evidence::inflation() const {
  const double by_halves = halves && halves->disagree ? halves->ratio * halves->ratio : 1;
  return std::max(bias.inflation, by_halves);
}

Evidence noise_of(const CalibrationFit& fit, const CalibrateOptions& options) {
  const int freedom = degrees_of_freedom(fit.bundle);
  Evidence evidence;
  evidence.sigma_from_residuals =
      !(options.sigma_px > 0) && !fit.whitened && freedom >= policy::kEnoughDegreesOfFreedom;
  evidence.sigma = options.sigma_px > 0            ? options.sigma_px
                   : fit.whitened                  ? 1
                   : evidence.sigma_from_residuals ? std::sqrt(fit.summary.cost / freedom)
                                                   : policy::kAssumedSigmaPx;
  evidence.floored_sigma = std::max(evidence.sigma, least_sigma(fit.whitened, options));
  evidence.seen = seen_region(fit.bundle);
  return evidence;
}

Evidence gather_evidence(const Solution& solution) {
  const auto begin = std::chrono::steady_clock::now();
  const CalibrationFit& fit = *solution.fit;
  Evidence evidence = noise_of(fit, *solution.options);
  evidence.distance_m = median_distance_m(fit.bundle);
  evidence.information = bundle_information(fit.bundle, solution.board);
  Observability& seen = evidence.observability;
  seen = observability(fit.bundle, evidence.information, evidence.sigma);
  const double share = evidence.sigma / evidence.floored_sigma;
  const double decrement = seen.covariance ? seen.covariance->decrement : 0;
  evidence.at_minimum =
      fit.summary.converged && share * share * decrement <= policy::kLargestDecrement;
  if (seen.covariance) {
    widen_by_profile(evidence, fit.bundle);
    find_lack_of_fit(evidence, solution);
    widen_by_lack_of_fit(evidence, solution);
  }
  evidence.target = find_target_error(evidence, solution);
  evidence.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return evidence;
}

std::optional<std::string> untested_principal_point(const Bundle& solved, double sigma) {
  if (solved.model->name() != "f" || !solved.model->held().empty()) return std::nullopt;
  const auto nested = nested_information(solved);
  const auto centred = covariance_of(solved, sigma);
  const auto open =
      nested ? step_to_larger_model(solved, *nested, Model::named("f+c"), sigma) : std::nullopt;
  if (!open || !centred) return std::nullopt;
  const double centred_px = std::sqrt(centred->parameters(0, 0));
  const double open_px = std::sqrt(open->covariance.parameters(0, 0));
  if (open_px < policy::kMuchLargerSd * centred_px) return std::nullopt;
  return "the principal point is taken to be the centre of the image, and the views do "
         "not determine it: with model f+c the standard deviation of the focal length "
         "would be " +
         px(open_px) + ", not " + px(centred_px);
}

std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples) {
  const ImageSize& size = solved.image_size;
  const double own_px = worst_corner_px(lens, size, samples);
  if (own_px > policy::kImageCornerShare * std::hypot(size.width, size.height))
    return "the standard deviation of the projection is " + px(own_px) +
           " at the corners of the image: the lens is extrapolated there";
  const Model& usual = lens.model->sibling("opencv5");
  if (lens.model->lens_type() != LensType::perspective ||
      lens.model->num_free() >= usual.num_free())
    return std::nullopt;
  const Bundle larger = with_model(solved, usual);
  const auto covariance = covariance_of(larger, sigma);
  if (!covariance) return std::nullopt;
  const double open_px =
      worst_corner_px({larger.model, larger.lens(), covariance->parameters}, size, samples);
  if (open_px < std::max(policy::kImageCornerPx, policy::kMuchLargerSd * own_px))
    return std::nullopt;
  return "the views do not show whether the lens has more distortion than model " +
         std::string(lens.model->name()) +
         ": with model opencv5 the standard deviation of the projection at the corners of the "
         "image is " +
         px(open_px) + ", not " + px(own_px) + "; the lens is extrapolated there";
}

bool is_impossible(const BoardWarp& bend, const FlatBoard& board) {
  const double largest_mm = policy::kLargestBoardBend * 2e3 * board.half_size.norm();
  return bend.bend_mm.cwiseAbs().maxCoeff() > largest_mm;
}

}  // namespace tagcal::internal
