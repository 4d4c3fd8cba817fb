#include "tagcal/estimate/calibration/model_ladder.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/convergence.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSmallestNoisePx = 1e-6;

// Squares in units of the noise, up to the bound beyond which corners are rejected: two fits that
// reject different ones are compared fairly only where no corner costs more than a rejected one.
struct Count {
  double noise_square = 1;
  double bound = 1;

  double operator()(double square) const { return std::min(square / noise_square, bound); }
};

// The squared residuals of a bundle's corners, each counted up to the rejection bound.
double counted_misfit(const Bundle& bundle, const Count& count) {
  double sum = 0;
  const Lens lens = bundle.lens();
  for (std::size_t v = 0; v < bundle.views.size(); ++v)
    for (const double square :
         whitened_squares(bundle.views[v], lens, bundle.camera_from_target[v]))
      sum += count(square);
  return sum;
}

// The same of all corners of a fit, the rejected ones included.
double counted_misfit(const CalibrationFit& fit, const Count& count) {
  double sum = 0;
  for (const double square : fit.squares) sum += count(square);
  return sum;
}

// The noise of the best fit among those that explain nearly as many corners as any.
double noise_square(const std::vector<Rung>& rungs, const CalibrateOptions& options) {
  int most = 0;
  for (const Rung& rung : rungs) most = std::max(most, num_corners(rung.bundle));
  double lowest = kInfinity;
  for (const Rung& rung : rungs) {
    const int freedom = degrees_of_freedom(rung.bundle);
    if (freedom < kEnoughDegreesOfFreedom || 10 * num_corners(rung.bundle) < 9 * most) continue;
    lowest = std::min(lowest, rung.summary.cost / freedom);
  }
  const double assumed = options.sigma_px > 0 ? options.sigma_px : kAssumedSigmaPx;
  if (!std::isfinite(lowest)) return assumed * assumed;
  return std::max(lowest, kSmallestNoisePx * kSmallestNoisePx);
}

Rung rung_from(const Bundle& start, const Model& model, int max_iterations) {
  Rung rung;
  rung.bundle = start;
  rung.bundle.model = &model;
  rung.bundle.free_values = model.free_values(start.lens());
  rung.summary = solve(rung.bundle, max_iterations);
  settle(rung.bundle, rung.summary, max_iterations);
  return rung;
}

bool is_fisheye(const Rung& rung) { return rung.model().lens_type() == LensType::fisheye; }

// A model contains those below it; what is not determined in one of them is not determined in it,
// while the smaller one explains the corners as well (its BIC is not higher). A fisheye's
// coefficients can make up the information of a focal length, too: it needs the plain pinhole's.
void pass_up_refusals(std::vector<Rung>& rungs) {
  std::vector<const Rung*> refused;
  for (Rung& rung : rungs) {
    for (const Rung* smaller : refused) {
      const bool plain =
          smaller->model().num_free() <= smaller->model().sibling("pinhole").num_free();
      if (rung.seen.status != Status::ok || smaller->bic > rung.bic || (is_fisheye(rung) && !plain))
        continue;
      rung.seen.status = smaller->seen.status;
      rung.seen.reason = smaller->seen.reason;
    }
    if (rung.seen.status == Status::focal_not_observable) refused.push_back(&rung);
  }
}

std::vector<Rung> climb_from(const CalibrationFit& fit, const CalibrateOptions& options) {
  const Model& model = *fit.bundle.model;
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const Bundle start = fisheye ? with_model(fit.bundle, model.sibling("f")) : fit.bundle;
  std::vector<Rung> rungs = climb(start, model.sibling("opencv8"), options.max_iterations);
  for (Rung& rung : rungs) rung.fit = &fit;
  return rungs;
}

Count count_in(const Ladder& ladder, const CalibrateOptions& options) {
  const double least = least_sigma(ladder.whitened, options);
  return {ladder.noise_square,
          kRejectSigmas * kRejectSigmas * std::max(1.0, least * least / ladder.noise_square)};
}

// How well a rung explains the corners.
void explain(Rung& rung, const Ladder& ladder, const Count& count) {
  const double rejected =
      counted_misfit(*rung.fit, count) - counted_misfit(rung.fit->bundle, count);
  rung.misfit = rejected + rung.summary.cost / ladder.noise_square;
  rung.bic = rejected + counted_misfit(rung.bundle, count) +
             rung.model().num_free() * std::log(ladder.num_residuals);
}

// The same of all, in units of the best one's noise.
void weigh(Ladder& ladder, const CalibrateOptions& options) {
  ladder.noise_square = noise_square(ladder.rungs, options);
  const Count count = count_in(ladder, options);
  for (Rung& rung : ladder.rungs) explain(rung, ladder, count);
}

// Climbs again, from another fit's poses: each rung stands where it explains more from there.
void improve(Ladder& ladder, const CalibrationFit& from, const CalibrateOptions& options) {
  const Count count = count_in(ladder, options);
  bool any = false;
  std::size_t i = 0;
  for (Rung& other : climb_from(from, options)) {
    Rung& rung = ladder.rungs[i++];
    explain(other, ladder, count);
    if (!other.summary.converged || (rung.summary.converged && other.bic >= rung.bic)) continue;
    rung = std::move(other);
    any = true;
  }
  if (any) weigh(ladder, options);
}

double lowest_bic(const Ladder& ladder, bool of_fisheye) {
  double lowest = kInfinity;
  for (const Rung& rung : ladder.rungs)
    if (is_fisheye(rung) == of_fisheye) lowest = std::min(lowest, rung.bic);
  return lowest;
}

// BIC asks for the larger model by the cost of one parameter and more.
bool is_far_worse(const Rung& small, const Rung& large) {
  const double noise_square = large.summary.cost / std::max(1, degrees_of_freedom(large.bundle));
  const int more = large.model().num_free() - small.model().num_free();
  return small.summary.cost - large.summary.cost >
         (more + 1) * std::log(2.0 * num_corners(large.bundle)) * noise_square;
}

// From poses that the smallest model bent to distortion a larger one may have found no way to its
// minimum: each is tried from `from`, if that is its model, and from the next larger one, down from
// the largest; followed where a few steps from there explain more.
void descend(std::vector<Rung>& rungs, const Bundle& from, int max_iterations) {
  constexpr int kFewSteps = 5;  // iterations, as a limit of work: a better basin shows at once
  for (std::size_t i = rungs.size(); i-- > 0;) {
    Rung& rung = rungs[i];
    const auto follow = [&](const Bundle& start) {
      Bundle trial = with_model(start, rung.model());
      if (cost_of(start) >= rung.summary.cost || solve(trial, kFewSteps).cost >= rung.summary.cost)
        return;
      Rung other = rung_from(trial, rung.model(), max_iterations);
      if (other.summary.converged && !at_fold(other.bundle, other.summary)) rung = std::move(other);
    };
    if (from.model == &rung.model()) follow(from);
    if (i + 1 < rungs.size() && rungs[i + 1].summary.converged && is_far_worse(rung, rungs[i + 1]))
      follow(rungs[i + 1].bundle);
  }
}

}  // namespace

std::vector<Rung> climb(const Bundle& from, const Model& top, int max_iterations) {
  std::vector<Rung> rungs;
  Bundle below = from;
  double lowest = kInfinity;
  for (const Model* model : from.model->siblings()) {
    if (model->lens_type() != LensType::perspective || model->num_free() > top.num_free()) continue;
    rungs.push_back(rung_from(below, *model, max_iterations));
    const Rung& rung = rungs.back();
    if (!rung.summary.converged || rung.summary.cost >= lowest) continue;
    lowest = rung.summary.cost;
    below = rung.bundle;
  }
  // What stands at a fold may have come there from a smaller lens on the wrong side of it.
  for (std::size_t i = rungs.size(); i-- > 0;) {
    if (!at_fold(rungs[i].bundle, rungs[i].summary)) continue;
    rungs[i].summary.converged = false;
    if (i + 1 == rungs.size() || !rungs[i + 1].summary.converged) continue;
    Rung again = rung_from(rungs[i + 1].bundle, rungs[i].model(), max_iterations);
    if (again.summary.converged && !at_fold(again.bundle, again.summary))
      rungs[i] = std::move(again);
  }
  descend(rungs, from, max_iterations);
  return rungs;
}

Ladder build_ladder(const LadderFits& fits, const CalibrateOptions& options) {
  const CalibrationFit *perspective = fits.perspective, *fisheye = fits.fisheye;
  Ladder ladder;
  if (perspective) ladder.rungs = climb_from(*perspective, options);
  if (fisheye) ladder.rungs.push_back({fisheye->bundle, fisheye->summary, fisheye});
  const CalibrationFit& any = perspective ? *perspective : *fisheye;
  ladder.num_residuals = 2 * any.num_corners;
  ladder.whitened = any.whitened;
  weigh(ladder, options);
  if (perspective && fits.other_perspective) improve(ladder, *fits.other_perspective, options);
  // Polynomials and the fisheye describe the same cameras up to some field of view: where the
  // fisheye explains the corners better, the perspectives may stand at second minima.
  if (perspective && fisheye && lowest_bic(ladder, true) < lowest_bic(ladder, false) &&
      well_in_front(fisheye->bundle))
    improve(ladder, *fisheye, options);
  const double sigma = options.sigma_px > 0 ? options.sigma_px : std::sqrt(ladder.noise_square);
  for (Rung& rung : ladder.rungs) {
    rung.seen = observability(rung.bundle, ladder.whitened ? 1.0 : sigma);
    rung.has_pole = has_pole({rung.bundle.lens(), rung.bundle.image_size});
  }
  pass_up_refusals(ladder.rungs);
  return ladder;
}

}  // namespace tagcal::internal
