#include "tagcal/estimate/checks/report.hpp"

#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/readout.hpp"
#include "tagcal/estimate/checks/checks.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal::internal {
namespace {

// Fills in the parts of an answer that need the fit only.
Calibration answer_of(const CalibrationFit& fit, const CalibrateOptions& options,
                      const Evidence& evidence) {
  Calibration c;
  c.model = fit.bundle.model->name();
  c.findings = fit.findings;
  c.num_iterations = fit.num_iterations;
  c.sigma_px = evidence.noise.sigma;
  c.sigma_from_residuals = evidence.noise.from_residuals;
  c.sigma_of_corners = fit.whitened && !(options.sigma_px > 0);
  c.seen = evidence.seen;
  c.seconds.start = fit.start_seconds;
  c.seconds.solve = fit.solve_seconds;
  return c;
}

// The same with a model that holds nothing: what is held has no variance.
UncertainCamera without_held(const UncertainCamera& known) {
  const Model& plain = Model::named(known.model->name());
  return {&plain, known.camera, covariance_by(plain, known)};
}

void fill_parameters(Calibration& c, const Model& model, const ModelChoice& choice) {
  for (const auto& [k, value] : model.held())
    c.fixed.emplace(parameter_names(c.camera->lens)[static_cast<std::size_t>(k)], value);
  const Posterior& posterior = choice.posterior;
  const UncertainCamera claim{&posterior.model(), *c.camera, choice.claim.parameters};
  c.claim = without_held(claim);
  c.covariance = covariance_by(model, claim);
  c.variance_inflation = posterior.covariance.overdispersion;
  c.row_sigma = posterior.fit.bundle.row_sigma;
  c.sigmas = lens_sigmas({&model, *c.camera, c.covariance});
}

void fill_views(Calibration& c, const CalibrationInput& input, const CalibrationFit& fit) {
  ViewProblem buffer;
  double sum = 0;
  for (std::size_t i = 0; i < fit.bundle.views.size(); ++i) {
    CalibratedView view;
    view.image = input.views[fit.used[i]].image;
    view.view = input.views[fit.used[i]].index;
    view.camera_from_world = fit.bundle.camera_from_target[i];
    view.residuals_px = residuals_px(fit.bundle.corrected(i, buffer).correspondences,
                                     fit.lens(fit.used[i]), view.camera_from_world);
    double view_sum = 0;
    for (const Eigen::Vector2d& r : view.residuals_px) view_sum += r.squaredNorm();
    view.num_corners = static_cast<int>(fit.bundle.views[i].correspondences.size());
    view.rms_px = std::sqrt(view_sum / view.num_corners);
    sum += view_sum;
    c.views.push_back(std::move(view));
  }
  c.outliers = outliers_of(input, fit);
  c.num_corners = fit.num_inliers();
  c.rms_px = std::sqrt(sum / c.num_corners);
}

std::optional<Readout> readout(const Solution& solution) {
  const CalibrationFit& fit = *solution.fit;
  const std::vector<double>& of_all = solution.options->times_s;
  if (of_all.empty() || !fit.has_perspective()) return std::nullopt;
  std::vector<double> times_s;
  for (const std::size_t v : fit.used) times_s.push_back(of_all[solution.input->views[v].index]);
  return readout_of(fit.bundle, times_s);
}

// The uncertainty of the projection: its weakest directions, and over the image.
void fill_projection(Calibration& c, const Solution& solution, const Evidence& evidence) {
  if (c.covariance.size() == 0) return;
  const Bundle& bundle = solution.fit->bundle;
  const std::vector<Eigen::Vector2d> samples = c.seen.samples();
  const UncertainCamera& lens = *c.claim;
  c.weak_directions = weak_directions(lens, samples);
  if (evidence.observability.status != Status::ok) return;
  std::vector<double> distances = {kInfinitelyFar, evidence.distance_m};
  for (const double distance : solution.options->distances_m)
    if (std::ranges::find(distances, distance) == distances.end()) distances.push_back(distance);
  for (const double distance : distances)
    c.projection.push_back(projection_uncertainty(lens, {bundle.image_size}, samples, distance));
}

// The scales of model weak, and the covariances of its poses.
void fill_scales(Calibration& c, const CalibrationFit& fit) {
  c.sigmas.assign(Parallel::kNumParameters, 0.0);
  for (std::size_t i = 0; i < c.views.size(); ++i) {
    CalibratedView& view = c.views[i];
    const WeakView& weak = fit.weak[i];
    view.mirrored = weak.mirrored;
    view.scale_px_per_m = weak.scale_px_per_m;
    view.scale_sigma_px_per_m = weak.scale_px_per_m * c.sigma_px * std::sqrt(weak.covariance(5, 5));
    view.covariance = c.sigma_px * c.sigma_px * weak.covariance;
    // The depth is unknown; scale_sigma_px_per_m has the uncertainty of the scale.
    view.covariance.row(5).setConstant(std::numeric_limits<double>::quiet_NaN());
    view.covariance.col(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

void add_findings(Solved& solved) {
  std::vector<Finding> findings = std::move(solved.answer.findings);
  run_checks(solved, findings);
  solved.answer.findings = std::move(findings);
  solved.answer.status = judge(solved.answer.findings);
}

}  // namespace

Calibration report(const Solution& solution, Evidence evidence) {
  const Stopwatch stopwatch;
  const CalibrationFit& fit = *solution.fit;
  Solved solved{solution, std::move(evidence), {}};
  Calibration& c = solved.answer;
  c = answer_of(fit, *solution.options, solved.evidence);
  c.camera = Camera{fit.bundle.lens(), fit.bundle.image_size};
  fill_views(c, *solution.input, fit);
  if (fit.has_perspective()) {
    fill_parameters(c, *fit.bundle.model, *solution.choice);
    for (std::size_t i = 0; i < c.views.size(); ++i)
      c.views[i].covariance = solution.choice->claim.poses[i];
    fill_projection(c, solution, solved.evidence);
  } else {
    fill_scales(c, fit);
  }
  c.board_warp = solved.evidence.board;
  c.readout = readout(solution);
  add_findings(solved);
  if (is_answer(c.status)) {
    c.halves = solved.evidence.halves;
  } else {  // claims that depend on the answer
    c.projection.clear();
    c.board_warp.reset();
  }
  c.seconds.covariance = solved.evidence.seconds + stopwatch.seconds();
  return std::move(solved.answer);
}

}  // namespace tagcal::internal
