#include "tagcal/estimate/checks/report.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/profile_covariance.hpp"
#include "tagcal/estimate/calibration/held_parameters.hpp"
#include "tagcal/estimate/checks/lack_of_fit.hpp"
#include "tagcal/estimate/checks/untested_assumptions.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
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

std::string correlated(const std::vector<std::string>& names) {
  return listed(names) +
         " are correlated: the projection is determined, their single values are not; a smaller "
         "model fits as well";
}

// A standard deviation beyond the image's diagonal says nothing.
std::string pixels(double sigma_px, const ImageSize& size) {
  if (!(sigma_px <= std::hypot(size.width, size.height))) return "no bound";
  return std::to_string(std::lround(sigma_px)) + " px";
}

// Returns the status by the rules of the design; the first reason not to answer wins.
Status judge(Calibration& c, const CalibrationFit& fit, const Observability& seen,
             const CalibrateOptions& options) {
  if (fit.num_inliers() < fit.num_corners / 2) {
    add(c.findings, code::no_consensus,
        "more than half of the corners are outliers of any common answer: check the target file "
        "and the ids of the tags");
    return Status::no_consensus;
  }
  if (seen.status != Status::ok) {
    add(c.findings, refusal_code(seen.status), seen.reason);
    return seen.status;
  }
  if (!fit.summary.converged) {
    add(c.findings, code::not_converged,
        "the solver did not converge: try a smaller model, or a start (--start, --focal)");
    return Status::not_converged;
  }
  const double share = c.sigma_px / sigma_with_floor(c, options);
  if (share * share * seen.decrement > policy::kLargestDecrement) {
    add(c.findings, code::not_converged,
        "the solver did not converge: it stopped where the distortion folds, not at a minimum; try "
        "a smaller model");
    return Status::not_converged;
  }
  if (policy::is_below(fit.num_inliers(), policy::kInliersOfUsualFit, fit.num_corners))
    add(c.findings, code::corners_rejected,
        percent(1 - static_cast<double>(fit.num_inliers()) / fit.num_corners) +
            " of the corners are outliers of this model and were rejected: check the corners, or "
            "take a larger model");
  if (!seen.open.empty()) add(c.findings, code::coefficients_correlated, correlated(seen.open));
  if (seen.focal_share > policy::kFocalWeak)
    add(c.findings, code::focal_weak,
        "the focal length is weakly determined: its standard deviation is " +
            percent(seen.focal_share) + " of it; take views with more tilt");
  return Status::ok;
}

// Widens the covariance of weakly determined parameters by their profile likelihood.
void widen_by_profile(Observability& seen, const Bundle& bundle,
                      const std::optional<BundleInformation>& information, double sigma) {
  if (seen.status != Status::ok || !seen.open.empty()) return;
  const Eigen::MatrixXd widened =
      profile_covariance(bundle, *information, seen.covariance->parameters, sigma);
  const Eigen::MatrixXd more = widened - seen.covariance->parameters;
  seen.covariance->parameters = widened;
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
    if (weak.sigma_px > policy::kProjectionWeakPx)
      add(c.findings, code::direction_weak,
          weak.sentence + " (" + pixels(weak.sigma_px, c.camera->image_size) + " at infinity)");
}

// Warns of the parts of the image without corners, and names the models that the uncertainty there
// assumes.
void warn_of_extrapolation(Calibration& c, const Bundle& bundle, const UncertainLens& lens,
                           std::span<const Eigen::Vector2d> samples,
                           const CalibrateOptions& options,
                           std::span<const SupportedModel> supported) {
  const bool is_by_name = !is_auto(options);
  auto gaps = c.seen.gaps();
  if (gaps && supported.empty())
    *gaps += "; the standard deviations there assume a lens of model " + c.model;
  if (gaps && !supported.empty()) {
    std::vector<std::string> names = {c.model};
    for (const SupportedModel& other : supported)
      if (other.weight > policy::kNamedModelWeight) names.emplace_back(other.bundle.model->name());
    *gaps += "; the standard deviations there assume a lens of model " + listed(names);
  }
  if (!gaps && is_by_name && c.covariance.size() > 0)
    gaps = extrapolated_corners(bundle, c.sigma_px, lens, samples);
  if (gaps) add(c.findings, code::extrapolated, std::move(*gaps));
  if (!is_by_name) return;
  if (auto sentence = untested_principal_point(bundle, c.sigma_px))
    add(c.findings, code::principal_point_untested, *sentence);
}

void warn_of_domain(Calibration& c) {
  if (has_pole(*c.camera))
    add(c.findings, code::pole_in_image,
        "the distortion has a pole inside the image: undistorting programs tear the image there; "
        "take model opencv5 or fisheye4 instead");
  const Eigen::MatrixXd& sigma_px = c.projection.front().sigma_px;
  const auto without_ray = sigma_px.array().isNaN().count();
  if (without_ray > 0)
    add(c.findings, code::fold_in_image,
        "the distortion folds before the border of the image: no ray meets " +
            std::to_string(without_ray) + " of " + std::to_string(sigma_px.size()) +
            " nodes of the grid over the image, so do not use the lens there");
}

// Fills in the uncertainty of the projection over the image, and the findings that need a
// covariance. `own`: the covariance of the model alone.
void fill_projection(Calibration& c, const LackOfFit& evidence, const Eigen::MatrixXd& own,
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
  warn_of_lack_of_fit(c, evidence);
}

// Widens the covariance by the lack of fit, the bend of the board and the other supported models.
// Returns the covariance without the other models, for projections.
Eigen::MatrixXd widen_by_evidence(Observability& seen, const CalibrationFit& fit,
                                  const LackOfFit& evidence,
                                  std::span<const SupportedModel> supported, double sigma) {
  BundleCovariance& covariance = *seen.covariance;
  const double inflation = evidence.inflation();
  covariance.parameters *= inflation;
  for (Matrix6& pose : covariance.poses) pose *= inflation;
  add_bend(covariance, evidence, sigma);
  if (seen.status == Status::ok) judge_focal_length(seen, fit.bundle);
  const Eigen::MatrixXd own = covariance.parameters;
  add_model_uncertainty(covariance, fit.bundle, fit.views, supported);
  // Another model that does not determine the focal length widens the covariance only; it does not
  // refuse the answer.
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
  } else if (freedom >= policy::kEnoughDegreesOfFreedom) {
    c.sigma_px = std::sqrt(fit.summary.cost / freedom);
    c.sigma_from_residuals = true;
  } else {
    c.sigma_px = policy::kAssumedSigmaPx;
    add(c.findings, code::noise_assumed,
        "no noise is stated, and there are too few residuals to estimate it: 0.5 px is assumed; "
        "state it with --sigma-px");
  }
  const double shown = freedom > 0 ? std::sqrt(fit.summary.cost / freedom) : 0;
  if (!c.sigma_from_residuals && freedom >= policy::kEnoughDegreesOfFreedom &&
      shown > policy::kNoiseUnderstated * c.sigma_px)
    add(c.findings, code::noise_understated,
        "the residuals are " + percent(shown / c.sigma_px) +
            " of the stated noise: the model, the target file or the stated noise is wrong");
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
  c.findings = fit.findings;
  c.num_iterations = fit.num_iterations;
  choose_sigma(c, fit, options);
  const auto information = bundle_information(fit.bundle, board);
  Observability seen =
      observability(fit.bundle, information, c.sigma_px, board && options.board_warp);
  widen_by_profile(seen, fit.bundle, information, c.sigma_px);
  LackOfFit evidence{&fit.bundle, information ? &*information : nullptr, board};
  Eigen::MatrixXd own;
  if (seen.covariance) {
    compare_residuals(c, evidence, options);
    judge_model_and_board(c, evidence, options);
    own = widen_by_evidence(seen, fit, evidence, supported, c.sigma_px);
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
