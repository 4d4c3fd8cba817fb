#include "tagcal/estimate/calibration/model_ladder.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
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
    if (!candidate.is_estimated) most = std::max(most, num_corners(candidate.bundle));
  double lowest = kInfinity;
  for (const Candidate& candidate : candidates) {
    const int freedom = degrees_of_freedom(candidate.bundle);
    const int inliers = num_corners(candidate.bundle);
    if (candidate.is_estimated || freedom < policy::kEnoughDegreesOfFreedom ||
        policy::is_below(inliers, policy::kComparableInliers, most))
      continue;
    lowest = std::min(lowest, candidate.summary.cost / freedom);
  }
  const double assumed = options.sigma_px > 0 ? options.sigma_px : policy::kAssumedSigmaPx;
  if (!std::isfinite(lowest)) return assumed * assumed;
  return std::max(lowest, policy::kLeastPoseSigmaPx * policy::kLeastPoseSigmaPx);
}

Candidate solved_from(const Bundle& start, const Model& model, int max_iterations) {
  Candidate candidate;
  candidate.bundle = with_model(start, model);
  candidate.summary = solve(candidate.bundle, max_iterations);
  continue_until_converged(candidate.bundle, candidate.summary, max_iterations);
  // A solver that stopped at the fold of a lens is at no minimum.
  if (stuck_at_domain_limit(candidate.bundle, candidate.summary))
    candidate.summary.converged = false;
  return candidate;
}

// BIC prefers the larger model, even with one more parameter than it has.
bool is_far_worse(const Candidate& small, const Candidate& large) {
  const double noise_square = large.summary.cost / std::max(1, degrees_of_freedom(large.bundle));
  const int more = large.model().num_free() - small.model().num_free();
  return small.summary.cost - large.summary.cost >
         (more + 1) * std::log(2.0 * num_corners(large.bundle)) * noise_square;
}

// Fits candidates that are far worse than the next larger one again from its poses, from the
// largest down: the poses of a much too small model may have led to a secondary minimum. Continues
// a trial whose cost is lower after a few steps.
void retry_from_larger_models(std::vector<Candidate>& candidates, int max_iterations) {
  constexpr int kFewSteps = 5;  // iterations, as a limit of work: a better basin shows at once
  for (std::size_t i = candidates.size() - 1; i-- > 0;) {
    Candidate& candidate = candidates[i];
    const Candidate& larger = candidates[i + 1];
    if (larger.is_estimated || !larger.summary.converged || !is_far_worse(candidate, larger))
      continue;
    Bundle trial = with_model(larger.bundle, candidate.model());
    if (solve(trial, kFewSteps).cost >= candidate.summary.cost) continue;
    Candidate other = solved_from(trial, candidate.model(), max_iterations);
    if (other.summary.converged) candidate = std::move(other);
  }
}

// The decrease of chi-square by the largest model that contains the bundle's, to first order; that
// of the models between is no larger.
double gain_of_largest(const Bundle& bundle, const BundleSummary& summary) {
  if (bundle.model->lens_type() != LensType::perspective) return 0;
  const auto nested = nested_information(bundle);
  if (!nested) return kInfinity;
  Eigen::MatrixXd information = nested->halves[0] + nested->halves[1];
  information.diagonal() *= 1 + policy::kUnobservablePrecision;
  const auto inverse = exact_inverse(information);
  if (!inverse) return kInfinity;
  const Eigen::VectorXd gradient = nested->gradients[0] + nested->gradients[1];
  const double variance = summary.cost / std::max(1, degrees_of_freedom(bundle));
  return gradient.dot(*inverse * gradient) / variance;
}

// The BIC of a larger model may come near that of a smaller one. `gain`: gain_of_largest.
bool may_win(const Model& larger, const Model& smaller, int num_residuals, double gain) {
  const int more = larger.num_free() - smaller.num_free();
  return more > 0 && gain > more * std::log(num_residuals) - policy::kStrongEvidence;
}

// The nested perspective models on the same corners. Each starts from the best smaller one, or from
// `from` if that start does not converge; and from the next larger one, if that is far better. If
// `may_estimate`, a model that cannot win against the last one fitted stays as it starts.
std::vector<Candidate> fit_nested(const Bundle& from, bool may_estimate, int max_iterations) {
  std::vector<Candidate> candidates;
  Candidate best{from, {false, kInfinity}};
  double gain = kInfinity;
  for (const Model* model : from.model->siblings()) {
    if (model->lens_type() != LensType::perspective) continue;
    Candidate& candidate = candidates.emplace_back(best);
    if (std::isfinite(gain) && !may_win(*model, best.model(), 2 * num_corners(from), gain)) {
      candidate.bundle = with_model(best.bundle, *model);
      candidate.is_estimated = true;
      continue;
    }
    candidate = solved_from(best.bundle, *model, max_iterations);
    if (!candidate.summary.converged) {
      Candidate other = solved_from(from, *model, max_iterations);
      if (other.summary.converged) candidate = std::move(other);
    }
    if (!candidate.summary.converged || candidate.summary.cost >= best.summary.cost) continue;
    best = candidate;
    if (may_estimate) gain = gain_of_largest(best.bundle, best.summary);
  }
  retry_from_larger_models(candidates, max_iterations);
  return candidates;
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

// Fits the perspectives from `start` on the inliers of `fit`; keeps those with a lower BIC than the
// ladder's.
void fit_from(ModelLadder& ladder, const Bundle& start, const CalibrationFit& fit,
              const CalibrateOptions& options) {
  std::vector<Candidate> others = fit_nested(start, ladder.may_estimate, options.max_iterations);
  for (Candidate& other : others) other.fit = &fit;
  if (ladder.candidates.empty() || ladder.candidates.front().is_fisheye()) {
    ladder.candidates.insert(ladder.candidates.begin(), std::make_move_iterator(others.begin()),
                             std::make_move_iterator(others.end()));
  } else {
    const TruncatedSquare truncate = truncated_square(ladder, options);
    for (std::size_t i = 0; i < others.size(); ++i) {
      Candidate& candidate = ladder.candidates[i];
      score(others[i], ladder, truncate);
      if (others[i].summary.converged &&
          (!candidate.summary.converged || others[i].bic < candidate.bic))
        candidate = std::move(others[i]);
    }
  }
  score_all(ladder, options);
}

// Both kinds of lens describe the same cameras up to some field of view. If the fisheye has the
// lowest BIC, the perspectives may be at secondary minima.
bool is_fisheye_best(const ModelLadder& ladder) {
  const Candidate& fisheye = ladder.candidates.back();
  return fisheye.is_fisheye() && within_perspective_field(fisheye.bundle) &&
         std::ranges::none_of(ladder.candidates,
                              [&](const Candidate& other) { return other.bic < fisheye.bic; });
}

// Sets what decides whether a candidate can be used.
void test_candidates(ModelLadder& ladder, const CalibrateOptions& options) {
  const double sigma = ladder.whitened || options.sigma_px <= 0 ? ladder.sigma() : options.sigma_px;
  for (Candidate& candidate : ladder.candidates) {
    if (candidate.is_estimated) continue;
    candidate.observability = observability(candidate.bundle, sigma);
    candidate.has_pole = has_pole({candidate.bundle.lens(), candidate.bundle.image_size});
  }
  refuse_larger_models(ladder.candidates);
}

// The BIC of a candidate on all views may come near that of `best`. `gain`: gain_of_largest.
bool is_contender(const Candidate& candidate, const Candidate& best, int num_residuals,
                  double gain) {
  return candidate.is_fisheye() == best.is_fisheye() &&
         (candidate.bic < best.bic + policy::kStrongEvidence ||
          may_win(candidate.model(), best.model(), num_residuals, gain));
}

// Estimates chi-square and BIC of the candidates that were not fitted to all views.
void estimate_others(ModelLadder& ladder, const ModelLadder& few, std::size_t best) {
  const double ratio = static_cast<double>(ladder.num_residuals) / few.num_residuals;
  const Candidate& base = ladder.candidates[best];
  for (std::size_t i = 0; i < ladder.candidates.size(); ++i) {
    Candidate& candidate = ladder.candidates[i];
    if (!candidate.is_estimated) continue;
    const double few_more = few.candidates[i].chi_square - few.candidates[best].chi_square;
    const double more = few_more > 0 ? ratio * few_more : few_more;  // noise does not grow
    candidate.chi_square = base.chi_square + more;
    candidate.bic =
        base.bic + more +
        (candidate.model().num_free() - base.model().num_free()) * std::log(ladder.num_residuals);
  }
}

}  // namespace

double ModelLadder::sigma() const { return whitened ? 1 : std::sqrt(noise_square); }

ModelLadder fit_ladder(const LensFits& fits, bool may_estimate, const CalibrateOptions& options) {
  ModelLadder ladder;
  ladder.may_estimate = may_estimate;
  const CalibrationFit& any = fits.fisheye ? *fits.fisheye : fits.perspectives.front();
  ladder.num_residuals = 2 * any.num_corners;
  ladder.whitened = any.whitened;
  if (fits.fisheye)
    ladder.candidates.push_back({fits.fisheye->bundle, fits.fisheye->summary, &*fits.fisheye});
  for (const CalibrationFit& fit : fits.perspectives) fit_from(ladder, fit.bundle, fit, options);
  score_all(ladder, options);
  if (!fits.perspectives.empty() && is_fisheye_best(ladder))
    fit_from(ladder, with_model(fits.fisheye->bundle, fits.fisheye->bundle.model->sibling("f")),
             *fits.fisheye, options);
  test_candidates(ladder, options);
  return ladder;
}

ModelLadder fit_contenders(const ModelLadder& few, const Candidate& best, const CalibrationFit& fit,
                           const CalibrationFit* rival, const CalibrateOptions& options) {
  ModelLadder ladder;
  ladder.num_residuals = 2 * fit.num_corners;
  ladder.whitened = fit.whitened;
  const double gain = gain_of_largest(fit.bundle, fit.summary);
  for (const Candidate& candidate : few.candidates) {
    if (&candidate == &best) {
      ladder.candidates.push_back({fit.bundle, fit.summary, &fit});
    } else if (rival && candidate.model().name() == rival->bundle.model->name()) {
      ladder.candidates.push_back({rival->bundle, rival->summary, rival});
    } else if (is_contender(candidate, best, ladder.num_residuals, gain)) {
      ladder.candidates.push_back(
          solved_from(fit.bundle, candidate.model(), options.max_iterations));
      ladder.candidates.back().fit = &fit;
    } else {
      ladder.candidates.push_back(candidate);
      ladder.candidates.back().is_estimated = true;
    }
  }
  score_all(ladder, options);
  estimate_others(ladder, few, static_cast<std::size_t>(&best - few.candidates.data()));
  test_candidates(ladder, options);
  return ladder;
}

}  // namespace tagcal::internal
