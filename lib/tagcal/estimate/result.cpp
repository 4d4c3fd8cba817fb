#include "tagcal/estimate/result.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/agreement.hpp"
#include "tagcal/estimate/halves.hpp"
#include "tagcal/estimate/observability.hpp"

namespace tagcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kAssumedSigmaPx = 0.5;
constexpr int kEnoughDegreesOfFreedom = 50;
constexpr double kBentChiSquare = 18.4;  // two degrees of freedom, p = 0.0001

// The noise by the rule: stated, else from the residuals where these are enough to show it.
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

void fill_sigmas(Calibration& c, const Model& model) {
  c.sigmas.assign(parameters(c.camera->lens).size(), 0.0);
  for (int i = 0; i < model.num_free(); ++i)
    for (const int k : model.free()[static_cast<std::size_t>(i)].lens_parameters)
      c.sigmas[static_cast<std::size_t>(k)] = std::sqrt(c.covariance(i, i));
}

// What the data can hold, by the rules of the design; the first reason not to answer wins.
Status judge(Calibration& c, const CalibrationFit& fit, const Observability& seen) {
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
  if (10 * fit.num_inliers() < 9 * fit.num_corners)
    c.warnings.push_back(percent(1 - static_cast<double>(fit.num_inliers()) / fit.num_corners) +
                         " of the corners agree with no answer of this model and were left out");
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
                    double distance_m) {
  c.halves = compare_halves(bundle, information, c.sigma_px, c.seen.samples(), distance_m);
  if (c.halves && c.halves->disagree)
    c.warnings.push_back("two halves of the views differ by " + percent(c.halves->ratio) +
                         " of what their noise explains: the model is too small, or the board is "
                         "bent or moved, and the standard deviations are too small");
}

// How well the lens is known over the image, and where it is not: all that needs a covariance.
void fill_projection(Calibration& c, const Bundle& bundle, const BundleInformation* information,
                     const CalibrateOptions& options) {
  c.seen = seen_region(bundle);
  const std::vector<Eigen::Vector2d> samples = c.seen.samples();
  const UncertainLens lens{bundle.model, c.camera->lens, c.covariance};
  if (c.covariance.size() > 0) warn_of_weak_directions(c, lens, samples);
  if (!is_answer(c.status)) return;
  for (std::string& gap : c.seen.gaps()) c.warnings.push_back(std::move(gap));
  const double near_m = median_distance_m(bundle);
  std::vector<double> distances = options.distances_m;
  if (distances.empty()) distances = {kInfinitelyFar, near_m};
  for (const double distance : distances)
    c.projection.push_back(projection_uncertainty(lens, {bundle.image_size}, samples, distance));
  if (information) warn_of_halves(c, bundle, *information, near_m);
}

// The bend of the board: part of the answer where it was asked for, else a warning where the
// corners show it.
void fill_warp(Calibration& c, const BundleInformation& information,
               const CalibrateOptions& options) {
  const std::optional<BoardWarp> warp = estimate_warp(information, c.sigma_px);
  if (!warp) return;
  if (options.board_warp) {
    c.board_warp = warp;
  } else if (warp->chi_square > kBentChiSquare) {
    char text[96];
    std::snprintf(text, sizeof text, "%.2g mm along x and %.2g mm along y", warp->bend_mm.x(),
                  warp->bend_mm.y());
    c.warnings.push_back("the corners fit a bent board better, by " + std::string(text) +
                         ": try --board-warp, or a larger model");
  }
}

CalibratedView weak_view(const WeakView& weak, const ViewProblem& problem,
                         const Eigen::Vector2d& centre, double sigma_px) {
  CalibratedView view;
  view.camera_from_world = weak.camera_from_target;
  view.mirrored = weak.mirrored;
  view.scale_px_per_m = weak.scale_px_per_m;
  view.scale_sigma_px_per_m = weak.scale_px_per_m * sigma_px * std::sqrt(weak.covariance(5, 5));
  view.covariance = sigma_px * sigma_px * weak.covariance;
  // Depth is not known; what the scale adds is kept to itself.
  view.covariance.row(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  view.covariance.col(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  view.num_corners = static_cast<int>(problem.correspondences.size());
  const Parallel lens({weak.scale_px_per_m, weak.scale_px_per_m, centre.x(), centre.y()});
  double sum = 0;
  for (const auto& r : residuals_px(problem.correspondences, lens, view.camera_from_world))
    sum += r.squaredNorm();
  view.rms_px = std::sqrt(sum / view.num_corners);
  return view;
}

// Residuals that go together are perspective, which this model does not have.
bool shows_perspective(const WeakFit& weak) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < weak.views.size(); ++v) {
    const Bundle& bundle = weak.fit.bundle;
    const Eigen::Vector2d centre = image_centre(bundle.image_size);
    const double s = weak.views[v].scale_px_per_m;
    std::vector<Eigen::Vector2d> pixels;
    for (const Correspondence& c : bundle.views[v].correspondences) pixels.push_back(c.pixel);
    count += go_together(pixels, residuals_px(bundle.views[v].correspondences,
                                              Parallel({s, s, centre.x(), centre.y()}),
                                              weak.views[v].camera_from_target));
  }
  return 2 * count > weak.views.size();
}

Status judge_weak(Calibration& c, const WeakFit& weak) {
  constexpr int kFewestDegreesOfFreedom = 11;  // as of other models (observability.cpp)
  const auto without_tilt = std::count_if(c.views.begin(), c.views.end(), [](const auto& view) {
    return !std::isfinite(view.covariance(0, 0));
  });
  if (without_tilt > 0)
    c.warnings.push_back(
        "in " + std::to_string(without_tilt) +
        " views the tilt has no standard deviation: the board is seen straight on");
  if (shows_perspective(weak))
    c.warnings.emplace_back(
        "the corners show perspective or distortion, which model weak does not have: try --model "
        "auto");
  if (weak.fit.num_inliers() < weak.fit.num_corners / 2) {
    c.warnings.emplace_back("more than half of the corners agree with no common answer");
    return Status::no_consensus;
  }
  if (degrees_of_freedom(weak.fit.bundle) < kFewestDegreesOfFreedom) {
    c.warnings.push_back("too few corners for the parameters: " + std::to_string(c.num_corners) +
                         " corners in " + std::to_string(c.views.size()) + " views");
    return Status::degenerate;
  }
  return Status::ok;
}

}  // namespace

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
  c.status = judge(c, fit, seen);
  fill_projection(c, fit.bundle, information ? &*information : nullptr, options);
  c.seconds.start = fit.start_seconds;
  c.seconds.solve = fit.solve_seconds;
  c.seconds.covariance = std::chrono::duration<double>(Clock::now() - begin).count();
  return c;
}

Calibration report_weak(const WeakFit& weak, const CalibrateOptions& options) {
  const Bundle& bundle = weak.fit.bundle;
  const Eigen::Vector2d centre = image_centre(bundle.image_size);
  Calibration c;
  c.model = "weak";
  c.camera = Camera{Parallel({1, 1, centre.x(), centre.y()}), bundle.image_size};
  c.sigmas.assign(Parallel::kNumParameters, 0.0);
  c.outliers = weak.fit.outliers;
  c.warnings = weak.fit.warnings;
  choose_sigma(c, weak.fit, options);
  double sum = 0;
  for (std::size_t v = 0; v < weak.views.size(); ++v) {
    c.views.push_back(weak_view(weak.views[v], bundle.views[v], centre, c.sigma_px));
    CalibratedView& view = c.views.back();
    view.image = weak.fit.images[v];
    sum += view.rms_px * view.rms_px * view.num_corners;
    c.num_corners += view.num_corners;
  }
  c.rms_px = std::sqrt(sum / std::max(1, c.num_corners));
  c.seen = seen_region(bundle);
  c.status = judge_weak(c, weak);
  c.seconds.solve = weak.fit.solve_seconds;
  return c;
}

}  // namespace tagcal
