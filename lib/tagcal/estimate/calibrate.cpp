#include "tagcal/estimate/calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/fit.hpp"
#include "tagcal/estimate/selection.hpp"
#include "tagcal/estimate/uncertainty.hpp"

namespace tagcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kAssumedSigmaPx = 0.5;
constexpr int kEnoughDegreesOfFreedom = 50;
constexpr double kFocalRefused = 0.10;  // sd(f) / f
constexpr double kFocalWeak = 0.05;
constexpr double kProjectionRefused = 0.02;  // of the half-diagonal

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100 * std::min(share, 1e4)))) + " %";
}

int degrees_of_freedom(const CalibrationFit& fit) {
  return 2 * fit.num_inliers() - fit.bundle.model->num_free() -
         6 * static_cast<int>(fit.bundle.views.size());
}

// The noise by the rule: stated, else from the residuals where these are enough to show it.
void choose_sigma(Calibration& c, const CalibrationFit& fit, const CalibrateOptions& options) {
  const int freedom = degrees_of_freedom(fit);
  if (options.sigma_px > 0) {
    c.sigma_px = options.sigma_px;
  } else if (fit.whitened) {
    c.sigma_px = 1;  // in units of the corners' own covariances
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

double relative_focal_sigma(const Calibration& c) {
  const std::span<const double> p = parameters(c.camera->lens);
  return std::max(c.sigmas[0] / p[0], c.sigmas[1] / p[1]);
}

// The free parameters, the focal length aside, that are least known in pixels at the image corner.
std::string weakest_parameters(const Calibration& c, const Model& model) {
  const double f = parameters(c.camera->lens)[0];
  const double radius =
      0.5 * std::hypot(c.camera->image_size.width, c.camera->image_size.height) / f;
  std::string names;
  double largest = 0;
  for (int i = 0; i < model.num_free(); ++i) {
    const std::string_view name = model.free()[static_cast<std::size_t>(i)].name;
    if (name[0] == 'f') continue;
    const double in_px = std::sqrt(c.covariance(i, i)) *
                         (name[0] == 'c' ? 1 : f * std::pow(radius, name[0] == 'k' ? 3 : 2));
    if (in_px > largest) names = name;
    largest = std::max(largest, in_px);
  }
  return names;
}

// What the data can hold, by the rules of the design; the first reason not to answer wins.
Status judge(Calibration& c, const CalibrationFit& fit,
             const std::optional<BundleCovariance>& cov) {
  const Model& model = *fit.bundle.model;
  if (fit.num_inliers() < fit.num_corners / 2) {
    c.warnings.push_back("more than half of the corners agree with no common answer");
    return Status::no_consensus;
  }
  if (degrees_of_freedom(fit) <= 10) {
    c.warnings.push_back(
        "too few corners for the parameters: " + std::to_string(fit.num_inliers()) +
        " corners in " + std::to_string(fit.bundle.views.size()) + " views");
    return Status::degenerate;
  }
  if (!cov) {
    c.warnings.push_back(
        "the focal length cannot be known from these views: tilt the board by 20 degrees or more");
    return Status::focal_not_observable;
  }
  const double focal = relative_focal_sigma(c);
  if (focal > kFocalRefused) {
    c.warnings.push_back("the focal length cannot be known from these views (sd " + percent(focal) +
                         "): tilt the board by 20 degrees or more, in several directions");
    return Status::focal_not_observable;
  }
  const double half_diagonal =
      0.5 * std::hypot(c.camera->image_size.width, c.camera->image_size.height);
  const double projection = projection_sigma_at_infinity_px(fit.bundle, c.covariance);
  if (!(projection < kProjectionRefused * half_diagonal)) {
    c.warnings.push_back("not observable from these views: " + weakest_parameters(c, model) +
                         " (the projection is uncertain by " +
                         std::to_string(std::lround(std::min(projection, 1e9))) + " px)");
    return Status::not_observable;
  }
  if (!fit.summary.converged) return Status::not_converged;
  if (10 * fit.num_inliers() < 9 * fit.num_corners)
    c.warnings.push_back(percent(1 - static_cast<double>(fit.num_inliers()) / fit.num_corners) +
                         " of the corners agree with no answer of this model and were left out");
  if (focal > kFocalWeak)
    c.warnings.push_back("the focal length is weakly known: sd " + percent(focal));
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

Calibration report(const CalibrationFit& fit, const CalibrateOptions& options) {
  const auto begin = Clock::now();
  Calibration c;
  const Model& model = *fit.bundle.model;
  c.model = model.name();
  c.camera = Camera{fit.bundle.lens(), fit.bundle.image_size};
  c.outliers = fit.outliers;
  c.warnings = fit.warnings;
  c.num_iterations = fit.num_iterations;
  choose_sigma(c, fit, options);
  const auto covariance = covariance_of(fit.bundle, c.sigma_px);
  if (covariance) {
    c.covariance = covariance->parameters;
    fill_sigmas(c, model);
  }
  fill_views(c, fit, covariance);
  c.status = judge(c, fit, covariance);
  c.seconds.start = fit.start_seconds;
  c.seconds.solve = fit.solve_seconds;
  c.seconds.covariance = seconds_since(begin);
  return c;
}

Calibration without_answer(const CalibrationInput& input, const std::string& model) {
  Calibration c;
  c.model = model;
  c.warnings = input.warnings;
  const bool any = !input.views.empty();
  c.status = any ? Status::no_consensus : Status::degenerate;
  c.warnings.push_back(any ? "in no view do the corners agree on a pose"
                           : "no view has four corners that are not on a line");
  return c;
}

}  // namespace

Calibration calibrate(const Dataset& dataset, const CalibrateOptions& options) {
  const auto begin = Clock::now();
  const bool choose = options.model.empty() || options.model == "auto";
  std::vector<const Model*> models;
  if (choose)
    models = {&Model::named("opencv5"), &Model::named("fisheye4")};
  else
    models = {&Model::named(options.model)};
  if (models.front()->lens_type() == LensType::parallel)
    throw Error("model: weak is an answer for what holds no focal length; it cannot be asked for");

  const CalibrationInput input = calibration_input(dataset);
  std::vector<CalibrationFit> fits;
  for (const Model* model : models) {
    std::optional<CalibrationFit> fit = fit_model(*model, input, options);
    if (fit) fits.push_back(std::move(*fit));
  }
  Calibration result;
  if (fits.empty()) {
    result = without_answer(input, std::string(models.front()->name()));
  } else {
    const std::size_t best = choose_fit(fits);
    result = report(fits[best], options);
    result.bic = fits[best].bic;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (i == best) continue;
      result.seconds.start += fits[i].start_seconds;
      result.seconds.solve += fits[i].solve_seconds;
    }
  }
  result.seconds.total = seconds_since(begin);
  return result;
}

}  // namespace tagcal
