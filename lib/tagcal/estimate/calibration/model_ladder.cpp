#include "tagcal/estimate/calibration/model_ladder.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/convergence.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// min(square / noise_square, bound), bound: that of rejection. Fits with different outliers are
// comparable only if no corner costs more than a rejected one.
struct TruncatedSquare {
  double noise_square = 1;
  double bound = 1;

  double operator()(double square) const { return std::min(square / noise_square, bound); }
};

// Sum over a bundle's corners.
double truncated_chi_square(const Bundle& bundle, const TruncatedSquare& truncate) {
  double sum = 0;
  const Lens lens = bundle.lens();
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const double square :
         whitened_squares(bundle.views[v], lens, bundle.camera_from_target[v]))
      sum += truncate(square);
  return sum;
}

// Sum over all corners of a fit, outliers included.
double truncated_chi_square(const CalibrationFit& fit, const TruncatedSquare& truncate) {
  double sum = 0;
  for (const double square : fit.squares) sum += truncate(square);
  return sum;
}

// Noise variance of the best fit, of those with about as many inliers as any.
double noise_square(const std::vector<Candidate>& candidates, const CalibrateOptions& options) {
  int most = 0;
  for (const Candidate& candidate : candidates)
    most = std::max(most, num_corners(candidate.bundle));
  double lowest = kInfinity;
  for (const Candidate& candidate : candidates) {
    const int freedom = degrees_of_freedom(candidate.bundle);
    const int inliers = num_corners(candidate.bundle);
    if (freedom < policy::kEnoughDegreesOfFreedom ||
        policy::is_below(inliers, policy::kComparableInliers, most))
      continue;
    lowest = std::min(lowest, candidate.summary.cost / freedom);
  }
  const double assumed = options.sigma_px > 0 ? options.sigma_px : policy::kAssumedSigmaPx;
  if (!std::isfinite(lowest)) return assumed * assumed;
  return std::max(lowest, policy::kExactNoisePx * policy::kExactNoisePx);
}

Candidate candidate_from(const Bundle& start, const Model& model, int max_iterations) {
  Candidate candidate;
  candidate.bundle = start;
  candidate.bundle.model = &model;
  candidate.bundle.free_values = model.free_values(start.lens());
  candidate.summary = solve(candidate.bundle, max_iterations);
  continue_until_converged(candidate.bundle, candidate.summary, max_iterations);
  return candidate;
}

// A model whose focal length is not observable refuses all larger ones, because they contain it, if
// its BIC is not higher. A fisheye is refused by models without distortion only: its coefficients,
// too, can make the focal length look observable.
void refuse_larger_models(std::vector<Candidate>& candidates) {
  std::vector<const Candidate*> refused;
  for (Candidate& candidate : candidates) {
    for (const Candidate* smaller : refused) {
      const bool is_plain =
          smaller->model().num_free() <= smaller->model().sibling("pinhole").num_free();
      if (candidate.observability.status != Status::ok || smaller->bic > candidate.bic ||
          (candidate.is_fisheye() && !is_plain))
        continue;
      candidate.observability.status = smaller->observability.status;
      candidate.observability.reason = smaller->observability.reason;
    }
    if (candidate.observability.status == Status::focal_not_observable)
      refused.push_back(&candidate);
  }
}

std::vector<Candidate> fit_nested_from(const CalibrationFit& fit, const CalibrateOptions& options) {
  const Model& model = *fit.bundle.model;
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const Bundle start = fisheye ? with_model(fit.bundle, model.sibling("f")) : fit.bundle;
  std::vector<Candidate> candidates =
      fit_nested(start, model.sibling("opencv8"), options.max_iterations);
  for (Candidate& candidate : candidates) candidate.fit = &fit;
  return candidates;
}

TruncatedSquare truncated_square(const ModelLadder& ladder, const CalibrateOptions& options) {
  const double least = least_sigma(ladder.whitened, options);
  return {ladder.noise_square, policy::kOutlierSigmas * policy::kOutlierSigmas *
                                   std::max(1.0, least * least / ladder.noise_square)};
}

// Sets chi-square and BIC of a candidate.
void score(Candidate& candidate, const ModelLadder& ladder, const TruncatedSquare& truncate) {
  const double rejected = truncated_chi_square(*candidate.fit, truncate) -
                          truncated_chi_square(candidate.fit->bundle, truncate);
  candidate.chi_square = rejected + candidate.summary.cost / ladder.noise_square;
  candidate.bic = rejected + truncated_chi_square(candidate.bundle, truncate) +
                  candidate.model().num_free() * std::log(ladder.num_residuals);
}

// Sets the noise, then chi-square and BIC of all candidates.
void score_all(ModelLadder& ladder, const CalibrateOptions& options) {
  ladder.noise_square = noise_square(ladder.candidates, options);
  const TruncatedSquare truncate = truncated_square(ladder, options);
  for (Candidate& candidate : ladder.candidates) score(candidate, ladder, truncate);
}

// Fits the ladder again from another fit's poses; keeps candidates with a lower BIC.
void retry_from(ModelLadder& ladder, const CalibrationFit& from, const CalibrateOptions& options) {
  const TruncatedSquare truncate = truncated_square(ladder, options);
  bool any = false;
  std::size_t i = 0;
  for (Candidate& other : fit_nested_from(from, options)) {
    Candidate& candidate = ladder.candidates[i++];
    score(other, ladder, truncate);
    if (!other.summary.converged || (candidate.summary.converged && other.bic >= candidate.bic))
      continue;
    candidate = std::move(other);
    any = true;
  }
  if (any) score_all(ladder, options);
}

double lowest_bic(const ModelLadder& ladder, bool of_fisheye) {
  double lowest = kInfinity;
  for (const Candidate& candidate : ladder.candidates)
    if (candidate.is_fisheye() == of_fisheye) lowest = std::min(lowest, candidate.bic);
  return lowest;
}

// BIC prefers the larger model, even with one more parameter than it has.
bool is_far_worse(const Candidate& small, const Candidate& large) {
  const double noise_square = large.summary.cost / std::max(1, degrees_of_freedom(large.bundle));
  const int more = large.model().num_free() - small.model().num_free();
  return small.summary.cost - large.summary.cost >
         (more + 1) * std::log(2.0 * num_corners(large.bundle)) * noise_square;
}

// Fits the candidates again, from the largest down: from `from`, if that is its model, and from the
// next larger one. A candidate whose start has the poses of a much too small model may have missed
// its minimum. Continues a trial whose cost is lower after a few steps.
void retry_from_larger_models(std::vector<Candidate>& candidates, const Bundle& from,
                              int max_iterations) {
  constexpr int kFewSteps = 5;  // iterations, as a limit of work: a better basin shows at once
  for (std::size_t i = candidates.size(); i-- > 0;) {
    Candidate& candidate = candidates[i];
    const auto try_from = [&](const Bundle& start) {
      Bundle trial = with_model(start, candidate.model());
      if (cost_of(start) >= candidate.summary.cost ||
          solve(trial, kFewSteps).cost >= candidate.summary.cost)
        return;
      Candidate other = candidate_from(trial, candidate.model(), max_iterations);
      if (other.summary.converged && !stuck_at_domain_limit(other.bundle, other.summary))
        candidate = std::move(other);
    };
    if (from.model == &candidate.model()) try_from(from);
    if (i + 1 < candidates.size() && candidates[i + 1].summary.converged &&
        is_far_worse(candidate, candidates[i + 1]))
      try_from(candidates[i + 1].bundle);
  }
}

}  // namespace

std::vector<Candidate> fit_nested(const Bundle& from, const Model& top, int max_iterations) {
  std::vector<Candidate> candidates;
  Bundle below = from;
  double lowest = kInfinity;
  for (const Model* model : from.model->siblings()) {
    if (model->lens_type() != LensType::perspective || model->num_free() > top.num_free()) continue;
    candidates.push_back(candidate_from(below, *model, max_iterations));
    const Candidate& candidate = candidates.back();
    if (!candidate.summary.converged || candidate.summary.cost >= lowest) continue;
    lowest = candidate.summary.cost;
    below = candidate.bundle;
  }
  // A fit at the fold of its lens may have started from a smaller model on the wrong side of it.
  for (std::size_t i = candidates.size(); i-- > 0;) {
    if (!stuck_at_domain_limit(candidates[i].bundle, candidates[i].summary)) continue;
    candidates[i].summary.converged = false;
    if (i + 1 == candidates.size() || !candidates[i + 1].summary.converged) continue;
    Candidate again =
        candidate_from(candidates[i + 1].bundle, candidates[i].model(), max_iterations);
    if (again.summary.converged && !stuck_at_domain_limit(again.bundle, again.summary))
      candidates[i] = std::move(again);
  }
  retry_from_larger_models(candidates, from, max_iterations);
  return candidates;
}

ModelLadder fit_ladder(const LadderFits& fits, const CalibrateOptions& options) {
  const CalibrationFit *perspective = fits.perspective, *fisheye = fits.fisheye;
  ModelLadder ladder;
  if (perspective) ladder.candidates = fit_nested_from(*perspective, options);
  if (fisheye) ladder.candidates.push_back({fisheye->bundle, fisheye->summary, fisheye});
  const CalibrationFit& any = perspective ? *perspective : *fisheye;
  ladder.num_residuals = 2 * any.num_corners;
  ladder.whitened = any.whitened;
  score_all(ladder, options);
  if (perspective && fits.other_perspective) retry_from(ladder, *fits.other_perspective, options);
  // Polynomials and the fisheye describe the same cameras up to some field of view: if the fisheye
  // has the lower BIC, the perspectives may be at secondary minima.
  if (perspective && fisheye && lowest_bic(ladder, true) < lowest_bic(ladder, false) &&
      within_perspective_field(fisheye->bundle))
    retry_from(ladder, *fisheye, options);
  const double sigma = options.sigma_px > 0 ? options.sigma_px : std::sqrt(ladder.noise_square);
  for (Candidate& candidate : ladder.candidates) {
    candidate.observability = observability(candidate.bundle, ladder.whitened ? 1.0 : sigma);
    candidate.has_pole = has_pole({candidate.bundle.lens(), candidate.bundle.image_size});
  }
  refuse_larger_models(ladder.candidates);
  return ladder;
}

}  // namespace tagcal::internal
