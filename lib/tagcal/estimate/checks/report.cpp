#include "tagcal/estimate/checks/report.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/profile_covariance.hpp"
#include "tagcal/estimate/checks/lack_of_fit.hpp"
#include "tagcal/estimate/checks/untested_assumptions.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Clock = std::chrono::steady_clock;

void fill_sigmas(Calibration& c, const Model& model) {
  c.sigmas.assign(parameters(c.camera->lens).size(), 0.0);
  for (int i = 0; i < model.num_free(); ++i)
    for (const int k : model.free()[static_cast<std::size_t>(i)].lens_parameters)
      c.sigmas[static_cast<std::size_t>(k)] = std::sqrt(c.covariance(i, i));
}

std::string trade(const std::vector<std::string>& names) {
  return listed(names) +
         " trade with one another: the projection is known, they are not; a smaller model would do";
}

// A standard deviation of the projection, where it says anything: within the image.
std::string pixels(double sigma_px, const ImageSize& size) {
  if (!(sigma_px <= std::hypot(size.width, size.height))) return "no bound";
  return std::to_string(std::lround(sigma_px)) + " px";
}

// What the data can hold, by the rules of the design; the first reason not to answer wins.
Status judge(Calibration& c, const CalibrationFit& fit, const Observability& seen,
             const CalibrateOptions& options) {
  if (fit.num_inliers() < fit.num_corners / 2) {
    c.warnings.emplace_back("more than half of the corners agree with no common answer");
    return Status::no_consensus;
  }
  if (seen.status != Status::ok) {
    c.warnings.push_back(seen.reason);
    return seen.status;
  }
  if (!fit.summary.converged) {
    c.warnings.emplace_back("the solution did not converge");
    return Status::not_converged;
  }
  const double share = c.sigma_px / sigma_that_counts(c, options);
  if (share * share * seen.decrement > kLargestDecrement) {
    c.warnings.emplace_back(
        "the solution did not converge: it stands where the lens folds, and not at a minimum");
    return Status::not_converged;
  }
  if (10 * fit.num_inliers() < 9 * fit.num_corners)
    c.warnings.push_back(percent(1 - static_cast<double>(fit.num_inliers()) / fit.num_corners) +
                         " of the corners agree with no answer of this model and were left out");
  if (!seen.open.empty()) c.warnings.push_back(trade(seen.open));
  if (seen.focal_share > kFocalWeak)
    c.warnings.push_back("the focal length is weakly known: sd " + percent(seen.focal_share));
  return Status::ok;
}

// Where parameters are held weakly, for the valley that they lie in.
void widen(Observability& seen, const Bundle& bundle,
           const std::optional<BundleInformation>& information, double sigma) {
  if (seen.status != Status::ok || !seen.open.empty()) return;
  const auto widened =
      widened_along_valley(bundle, *information, seen.covariance->parameters, sigma);
  if (!widened) return;
  const Eigen::MatrixXd more = *widened - seen.covariance->parameters;
  seen.covariance->parameters = *widened;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto by_parameters = information->pose_by_parameters[v].leftCols(more.cols());
    seen.covariance->poses[v] += by_parameters * more * by_parameters.transpose();
  }
}

void fill_views(Calibration& c, const CalibrationFit& fit,
                const std::optional<BundleCovariance>& covariance) {
  const Lens& lens = c.camera->lens;
  double sum = 0;
  for (std::size_t i = 0; i < fit.bundle.views.size(); ++i) {
    CalibratedView view;
    view.image = fit.images[i];
    view.view = fit.views[i];
    view.camera_from_world = fit.bundle.camera_from_target[i];
    if (covariance) view.covariance = covariance->poses[i];
    double view_sum = 0;
    for (const auto& r :
         residuals_px(fit.bundle.views[i].correspondences, lens, view.camera_from_world))
      view_sum += r.squaredNorm();
    view.num_corners = static_cast<int>(fit.bundle.views[i].correspondences.size());
    view.rms_px = std::sqrt(view_sum / view.num_corners);
    sum += view_sum;
    c.views.push_back(view);
  }
  c.num_corners = fit.num_inliers();
  c.rms_px = std::sqrt(sum / c.num_corners);
}

void warn_of_weak_directions(Calibration& c, const UncertainLens& lens,
                             const std::vector<Eigen::Vector2d>& samples) {
  c.weak_directions = weak_directions(lens, samples);
  for (const WeakDirection& weak : c.weak_directions)
    if (weak.sigma_px > kProjectionWeakPx)
      c.warnings.push_back(weak.sentence + " (" + pixels(weak.sigma_px, c.camera->image_size) +
                           " at infinity)");
}

// The parts of the image without corners, and under which assumption something is claimed there.
void warn_of_extrapolation(Calibration& c, const Bundle& bundle, const UncertainLens& lens,
                           std::span<const Eigen::Vector2d> samples,
                           const CalibrateOptions& options,
                           std::span<const SupportedModel> supported) {
  const bool is_by_name = !options.model.empty() && options.model != "auto";
  auto gaps = c.seen.gaps();
  if (gaps && supported.empty())
    *gaps += "; what is claimed there holds for a lens of model " + c.model;
  if (gaps && !supported.empty()) {
    std::vector<std::string> names = {c.model};
    for (const SupportedModel& other : supported)
      if (other.weight > kWorthAWord) names.emplace_back(other.bundle.model->name());
    *gaps += "; what is claimed there holds for a lens of model " + listed(names);
  }
  if (!gaps && is_by_name && c.covariance.size() > 0)
    gaps = extrapolated_corners(bundle, c.sigma_px, lens, samples);
  if (gaps) c.warnings.push_back(std::move(*gaps));
  if (!is_by_name) return;
  if (auto sentence = assumed_centre(bundle, c.sigma_px)) c.warnings.push_back(*sentence);
}

void warn_of_domain(Calibration& c) {
  if (has_pole(*c.camera))
    c.warnings.emplace_back(
        "the distortion has a pole inside the image: undistorting programs tear the image there; "
        "take model opencv5 or fisheye4");
  const Eigen::MatrixXd& sigma_px = c.projection.front().sigma_px;
  const auto silent = sigma_px.array().isNaN().count();
  if (silent > 0)
    c.warnings.push_back(
        "the lens folds before the border of the image: no projection is claimed "
        "at " +
        std::to_string(silent) + " of " + std::to_string(sigma_px.size()) + " nodes");
}

// How well the lens is known over the image, and where it is not: all that needs a covariance.
// `own`: the covariance of the model alone.
void fill_projection(Calibration& c, const MisfitEvidence& evidence, const Eigen::MatrixXd& own,
                     const CalibrateOptions& options, std::span<const SupportedModel> supported) {
  const Bundle& bundle = *evidence.bundle;
  c.seen = seen_region(bundle);
  const std::vector<Eigen::Vector2d> samples = c.seen.samples();
  const UncertainLens lens{bundle.model, c.camera->lens, own};
  if (c.covariance.size() > 0) warn_of_weak_directions(c, lens, samples);
  if (!is_answer(c.status)) return;
  warn_of_extrapolation(c, bundle, lens, samples, options, supported);
  const double near_m = median_distance_m(bundle);
  std::vector<double> distances = options.distances_m;
  if (distances.empty()) distances = {kInfinitelyFar, near_m};
  for (const double distance : distances) {
    c.projection.push_back(projection_uncertainty(lens, {bundle.image_size}, samples, distance));
    add_model_uncertainty(c.projection.back(), *c.camera, supported, samples);
  }
  warn_of_domain(c);
  warn_of_misfit(c, evidence);
}

// What is claimed: the covariance of the model, with all that was assumed for it and that the
// corners contradict or do not tell. Returns that of the model alone, for projections.
Eigen::MatrixXd claim(Observability& seen, const CalibrationFit& fit,
                      const MisfitEvidence& evidence, std::span<const SupportedModel> supported,
                      double sigma) {
  BundleCovariance& covariance = *seen.covariance;
  const double inflation = evidence.inflation();
  covariance.parameters *= inflation;
  for (Matrix6& pose : covariance.poses) pose *= inflation;
  count_bend(covariance, evidence, sigma);
  if (seen.status == Status::ok) judge_focal_length(seen, fit.bundle);
  const Eigen::MatrixXd own = covariance.parameters;
  add_model_uncertainty(covariance, fit.bundle, fit.views, supported);
  // Another model that would not determine the focal length widens the claim, and refuses nothing.
  seen.focal_share = relative_focal_sigma(fit.bundle, covariance.parameters);
  return own;
}

}  // namespace

void choose_sigma(Calibration& c, const CalibrationFit& fit, const CalibrateOptions& options) {
  const int freedom = degrees_of_freedom(fit.bundle);
  if (options.sigma_px > 0) {
    c.sigma_px = options.sigma_px;
  } else if (fit.whitened) {
    c.sigma_px = 1;
    c.sigma_of_corners = true;
  } else if (freedom >= kEnoughDegreesOfFreedom) {
    c.sigma_px = std::sqrt(fit.summary.cost / freedom);
    c.sigma_from_residuals = true;
  } else {
    c.sigma_px = kAssumedSigmaPx;
    c.warnings.emplace_back(
        "no noise is stated and the residuals are too few to show it: 0.5 px is assumed");
  }
  const double shown = freedom > 0 ? std::sqrt(fit.summary.cost / freedom) : 0;
  if (!c.sigma_from_residuals && freedom >= kEnoughDegreesOfFreedom && shown > 1.5 * c.sigma_px)
    c.warnings.push_back("the residuals are " + percent(shown / c.sigma_px) +
                         " of the stated noise: the model, the target or the noise is not right");
}

Calibration report(const CalibrationFit& fit, const CalibrateOptions& options,
                   const FlatBoard* board, std::span<const SupportedModel> supported) {
  const auto begin = Clock::now();
  Calibration c;
  const Model& model = *fit.bundle.model;
  c.model = model.name();
  c.camera = Camera{fit.bundle.lens(), fit.bundle.image_size};
  for (const auto& [k, value] : model.held())
    c.fixed.emplace(parameter_names(c.camera->lens)[static_cast<std::size_t>(k)], value);
  c.outliers = fit.outliers;
  c.warnings = fit.warnings;
  c.num_iterations = fit.num_iterations;
  choose_sigma(c, fit, options);
  const auto information = bundle_information(fit.bundle, board);
  Observability seen =
      observability(fit.bundle, information, c.sigma_px, board && options.board_warp);
  widen(seen, fit.bundle, information, c.sigma_px);
  MisfitEvidence evidence{&fit.bundle, information ? &*information : nullptr, board};
  Eigen::MatrixXd own;
  if (seen.covariance) {
    compare_residuals(c, evidence, options);
    judge_model_and_board(c, evidence, options);
    own = claim(seen, fit, evidence, supported, c.sigma_px);
    c.variance_inflation = evidence.inflation();
    c.covariance = seen.covariance->parameters;
    fill_sigmas(c, model);
  }
  fill_views(c, fit, seen.covariance);
  c.status = judge(c, fit, seen, options);
  fill_projection(c, evidence, own, options, supported);
  c.seconds.start = fit.start_seconds;
  c.seconds.solve = fit.solve_seconds;
  c.seconds.covariance = std::chrono::duration<double>(Clock::now() - begin).count();
  return c;
}

}  // namespace tagcal::internal
