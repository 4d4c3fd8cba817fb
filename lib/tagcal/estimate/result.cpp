#include "tagcal/estimate/result.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/agreement.hpp"
#include "tagcal/estimate/doubt.hpp"
#include "tagcal/estimate/halves.hpp"
#include "tagcal/estimate/observability.hpp"
#include "tagcal/estimate/residual_field.hpp"

namespace tagcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kAssumedSigmaPx = 0.5;
constexpr int kEnoughDegreesOfFreedom = 50;
constexpr double kBentChiSquare = 18.4;  // two degrees of freedom, p = 0.0001

void fill_sigmas(Calibration& c, const Model& model) {
  c.sigmas.assign(parameters(c.camera->lens).size(), 0.0);
  for (int i = 0; i < model.num_free(); ++i)
    for (const int k : model.free()[static_cast<std::size_t>(i)].lens_parameters)
      c.sigmas[static_cast<std::size_t>(k)] = std::sqrt(c.covariance(i, i));
}

std::string trade(const std::vector<std::string>& names) {
  std::string text = names[0];
  for (std::size_t i = 1; i < names.size(); ++i)
    text += (i + 1 < names.size() ? ", " : " and ") + names[i];
  return text +
         " trade with one another: the projection is known, they are not; a smaller model would do";
}

// For what doubts the answer: digits in a file, below the least noise that there is, are no error.
double sigma_that_counts(const Calibration& c, const CalibrateOptions& options) {
  return std::max(c.sigma_px, least_sigma(c.sigma_of_corners, options));
}

// What the data can hold, by the rules of the design; the first reason not to answer wins.
Status judge(Calibration& c, const CalibrationFit& fit, const Observability& seen,
             const CalibrateOptions& options) {
  if (fit.num_inliers() < fit.num_corners / 2) {
    c.warnings.push_back("more than half of the corners agree with no common answer");
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

void fill_views(Calibration& c, const CalibrationFit& fit,
                const std::optional<BundleCovariance>& covariance) {
  const Lens& lens = c.camera->lens;
  double sum = 0;
  for (std::size_t i = 0; i < fit.bundle.views.size(); ++i) {
    CalibratedView view;
    view.image = fit.images[i];
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
      c.warnings.push_back(weak.sentence + " (" +
                           std::to_string(std::lround(std::min(weak.sigma_px, 1e9))) +
                           " px at infinity)");
}

void warn_of_halves(Calibration& c, const Bundle& bundle, const BundleInformation& information,
                    const CalibrateOptions& options, double distance_m) {
  c.halves = compare_halves(bundle, information, sigma_that_counts(c, options), c.seen.samples(),
                            distance_m);
  if (c.halves && c.halves->disagree)
    c.warnings.push_back("two halves of the views differ by " + percent(c.halves->ratio) +
                         " of what their noise explains: the model is too small, or the board is "
                         "bent or moved, and the standard deviations are too small");
}

void warn_of_field(Calibration& c, const Bundle& bundle, const CalibrateOptions& options) {
  const ResidualField field = residual_field(bundle, least_sigma(c.sigma_of_corners, options));
  if (!field.disagree) return;
  char text[32];
  std::snprintf(text, sizeof text, "%.2g px", field.rms_px);
  c.warnings.push_back("the residuals differ from place to place in the image, by " +
                       std::string(text) +
                       " RMS: the model is too small, or the board is bent, and the standard "
                       "deviations are too small");
}

// How well the lens is known over the image, and where it is not: all that needs a covariance.
void fill_projection(Calibration& c, const Bundle& bundle, const BundleInformation* information,
                     const CalibrateOptions& options) {
  c.seen = seen_region(bundle);
  const std::vector<Eigen::Vector2d> samples = c.seen.samples();
  const UncertainLens lens{bundle.model, c.camera->lens, c.covariance};
  if (c.covariance.size() > 0) warn_of_weak_directions(c, lens, samples);
  if (!is_answer(c.status)) return;
  if (auto sentence = assumed_centre(bundle, c.sigma_px)) c.warnings.push_back(*sentence);
  for (std::string& gap : c.seen.gaps()) c.warnings.push_back(std::move(gap));
  const double near_m = median_distance_m(bundle);
  std::vector<double> distances = options.distances_m;
  if (distances.empty()) distances = {kInfinitelyFar, near_m};
  for (const double distance : distances)
    c.projection.push_back(projection_uncertainty(lens, {bundle.image_size}, samples, distance));
  warn_of_field(c, bundle, options);
  if (information) warn_of_halves(c, bundle, *information, options, near_m);
}

// The bend of the board: part of the answer where it was asked for, else a warning where the
// corners show it.
void fill_warp(Calibration& c, const BundleInformation& information,
               const CalibrateOptions& options) {
  const std::optional<BoardWarp> warp = estimate_warp(information, c.sigma_px);
  if (!warp) return;
  if (options.board_warp) {
    c.board_warp = warp;
    return;
  }
  const double share = c.sigma_px / sigma_that_counts(c, options);
  if (share * share * warp->chi_square > kBentChiSquare) {
    char text[96];
    std::snprintf(text, sizeof text, "%.2g mm along x and %.2g mm along y", warp->bend_mm.x(),
                  warp->bend_mm.y());
    c.warnings.push_back("the corners fit a bent board better, by " + std::string(text) +
                         ": try --board-warp, or a larger model");
  }
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
    c.warnings.push_back(
        "no noise is stated and the residuals are too few to show it: 0.5 px is assumed");
  }
  const double shown = freedom > 0 ? std::sqrt(fit.summary.cost / freedom) : 0;
  if (!c.sigma_from_residuals && freedom >= kEnoughDegreesOfFreedom && shown > 1.5 * c.sigma_px)
    c.warnings.push_back("the residuals are " + percent(shown / c.sigma_px) +
                         " of the stated noise: the model, the target or the noise is not right");
}

Calibration report(const CalibrationFit& fit, const CalibrateOptions& options,
                   const FlatBoard* board) {
  const auto begin = Clock::now();
  Calibration c;
  const Model& model = *fit.bundle.model;
  c.model = model.name();
  c.camera = Camera{fit.bundle.lens(), fit.bundle.image_size};
  c.outliers = fit.outliers;
  c.warnings = fit.warnings;
  c.num_iterations = fit.num_iterations;
  choose_sigma(c, fit, options);
  const auto information = bundle_information(fit.bundle, board);
  const Observability seen =
      observability(fit.bundle, information, c.sigma_px, board && options.board_warp);
  if (seen.covariance) {
    c.covariance = seen.covariance->parameters;
    fill_sigmas(c, model);
  }
  if (board && seen.covariance) fill_warp(c, *information, options);
  fill_views(c, fit, seen.covariance);
  c.status = judge(c, fit, seen, options);
  fill_projection(c, fit.bundle, information ? &*information : nullptr, options);
  c.seconds.start = fit.start_seconds;
  c.seconds.solve = fit.solve_seconds;
  c.seconds.covariance = std::chrono::duration<double>(Clock::now() - begin).count();
  return c;
}

}  // namespace tagcal
