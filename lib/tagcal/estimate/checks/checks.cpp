#include "tagcal/estimate/checks/checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/estimate/checks/board_checks.hpp"
#include "tagcal/estimate/checks/shutter_checks.hpp"
#include "tagcal/estimate/checks/weak_checks.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

using Result = std::optional<Finding>;

// A standard deviation beyond the image's diagonal says nothing.
std::string pixels(double sigma_px, const ImageSize& size) {
  if (!(sigma_px <= std::hypot(size.width, size.height))) return "no bound";
  return std::to_string(std::lround(sigma_px)) + " px";
}

// The noise.

Result noise_assumed(const Solved& s) {
  const bool is_stated = s.solution.options->sigma_px > 0;
  if (is_stated || s.answer.sigma_of_corners || s.answer.sigma_from_residuals) return std::nullopt;
  return finding(code::noise_assumed,
                 "no noise is stated, and there are too few residuals to estimate it: 0.5 px is "
                 "assumed; state it with --sigma-px");
}

Result noise_understated(const Solved& s) {
  const int freedom = degrees_of_freedom(s.solution.fit->bundle);
  if (s.answer.sigma_from_residuals || freedom < policy::kEnoughDegreesOfFreedom)
    return std::nullopt;
  const double ratio = std::sqrt(s.solution.fit->summary.cost / freedom) / s.answer.sigma_px;
  if (!(ratio > policy::kMuchLargerSd)) return std::nullopt;
  return finding(
      code::noise_understated,
      "the residuals are " + percent(ratio) +
          " of the stated noise: the model, the target file or the stated noise is wrong");
}

// Reasons not to answer, in this order.

Result choice_refused(const Solved& s) { return s.solution.refusal; }

Result too_few_inliers(const Solved& s) {
  if (s.solution.fit->num_inliers() >= s.solution.fit->num_corners / 2) return std::nullopt;
  return finding(code::no_consensus,
                 "more than half of the corners are outliers of any common answer: check the "
                 "target file and the ids of the tags");
}

Result wrong_target(const Solved& s) {
  // A user who keeps all corners trusts the target.
  if (!s.evidence.target || !s.evidence.target->gross || !s.solution.options->reject_outliers)
    return std::nullopt;
  return finding(code::no_consensus,
                 "the corners are not consistent with the target file: too many of its tags are "
                 "displaced");
}

Result unobservable(const Solved& s) {
  const Observability& seen = s.evidence.observability;
  if (seen.status == Status::ok) return std::nullopt;
  return finding(refusal_code(seen.status), seen.reason);
}

Result not_converged(const Solved& s) {
  if (s.evidence.at_minimum) return std::nullopt;
  if (!s.solution.fit->summary.converged)
    return finding(code::not_converged,
                   "the solver did not converge: try a smaller model, or a start (--start, "
                   "--focal)");
  return finding(code::not_converged,
                 "the solver did not converge: it stopped where the distortion folds, not at a "
                 "minimum; try a smaller model");
}

// The target.

Result tags_misplaced(const Solved& s) {
  return s.evidence.target ? s.evidence.target->tags_misplaced : std::nullopt;
}

Result tag_scale(const Solved& s) {
  return s.evidence.target ? s.evidence.target->tag_scale : std::nullopt;
}

Result board_bent(const Solved& s) {
  if (!s.evidence.board) return std::nullopt;
  return check_bend(*s.evidence.board, *s.solution.fit->bundle.board);
}

Result print_aspect(const Solved& s) {
  if (!s.evidence.board) return std::nullopt;
  return check_print(*s.evidence.board, *s.solution.fit->bundle.board);
}

// The model.

Result model_too_small(const Solved& s) {
  if (is_auto(*s.solution.options) || !s.evidence.is_model_small()) return std::nullopt;
  return finding(code::model_too_small,
                 "the model underfits: opencv5 reduces the squared residuals by " +
                     percent(s.evidence.larger->share) + "; use opencv5 or auto");
}

Result other_lens(const Solved& s) {
  const double share = s.solution.choice->other_lens_share;
  if (!(share > 0)) return std::nullopt;
  return finding(code::other_lens,
                 "opencv5, another kind of lens, reduces the squared residuals by " +
                     percent(share) + ": use it, or auto");
}

constexpr std::string_view kCause =
    "; the model is too small, or the board moved or is bent; the standard deviations "
    "include it as far as the views differ";

Result residuals_biased(const Solved& s) {
  if (!s.evidence.bias.disagree) return std::nullopt;
  return finding(code::residuals_biased,
                 "the residuals differ from place to place in the image, by " +
                     with_digits(s.evidence.bias.rms_px, 2) + " px RMS" + std::string(kCause));
}

Result halves_disagree(const Solved& s) {
  const auto& halves = s.evidence.halves;
  if (!halves || !halves->disagree || !halves->source.empty()) return std::nullopt;
  return finding(code::halves_disagree, "calibrations of two halves of the views differ by " +
                                            with_digits(halves->ratio, 2) +
                                            " times the expected standard deviation" +
                                            std::string(kCause));
}

Result sources_disagree(const Solved& s) {
  const auto& halves = s.evidence.halves;
  if (!halves || !halves->disagree || halves->source.empty()) return std::nullopt;
  return finding(code::sources_disagree,
                 "the pictures of " + halves->source +
                     " and the other pictures give lenses that "
                     "differ by " +
                     with_digits(halves->ratio, 2) +
                     " times the expected standard deviation: they are of two cameras, or the "
                     "focus or zoom changed between them; calibrate each of them alone");
}

Result pole_in_image(const Solved& s) {
  if (!has_pole(*s.answer.camera)) return std::nullopt;
  return finding(code::pole_in_image,
                 "the distortion has a pole inside the image: undistorting programs tear the "
                 "image there; take model opencv5 or fisheye4 instead");
}

Result fold_in_image(const Solved& s) {
  const Eigen::MatrixXd& sigma_px = s.answer.projection.front().sigma_px;
  const auto without_ray = sigma_px.array().isNaN().count();
  if (without_ray == 0) return std::nullopt;
  return finding(
      code::fold_in_image,
      "the distortion folds before the border of the image: " +
          percent(static_cast<double>(without_ray) / static_cast<double>(sigma_px.size())) +
          " of the image is outside the lens model; do not use the lens there");
}

// Limits of what the data determine.

Result corners_rejected(const Solved& s) {
  const CalibrationFit& fit = *s.solution.fit;
  if (!policy::is_below(fit.num_inliers(), policy::kComparableInliers, fit.num_corners))
    return std::nullopt;
  return finding(code::corners_rejected,
                 percent(1 - static_cast<double>(fit.num_inliers()) / fit.num_corners) +
                     " of the corners are outliers of this model and were rejected: check the "
                     "corners, or take a larger model");
}

// Coefficients of which the data say little more than their priors.
Result coefficients_correlated(const Solved& s) {
  const Bundle& bundle = s.solution.fit->bundle;
  const auto information = s.solution.choice->posterior.information.prior.diagonal();
  std::vector<std::string> names;
  const Posterior& posterior = s.solution.choice->posterior;
  for (int i = 0; i < posterior.model().num_free(); ++i) {
    const FreeParameter& free = posterior.model().free()[static_cast<std::size_t>(i)];
    const double prior = 1 / std::sqrt(information[i]);
    const double sigma = std::sqrt(s.solution.choice->claim.parameters(i, i));
    const bool is_free = std::ranges::find(bundle.model->free(), free.name, &FreeParameter::name) !=
                         bundle.model->free().end();
    const ParameterRole role = posterior.model().parameter(static_cast<std::size_t>(i)).role;
    const bool is_curve = role == ParameterRole::radial || role == ParameterRole::shape;
    if (is_free && is_curve && sigma > policy::kLikePrior * prior) names.emplace_back(free.name);
  }
  if (names.empty()) return std::nullopt;
  return finding(
      code::coefficients_correlated,
      listed(names) +
          (names.size() == 1
               ? " is correlated with others: the projection is determined, its value is "
                 "not; a smaller model fits as well"
               : " are correlated: the projection is determined, their single values are "
                 "not; a smaller model fits as well"));
}

Result direction_weak(const Solved& s) {
  std::string sentence;
  for (const WeakDirection& weak : s.answer.weak_directions)
    if (weak.sigma_px > policy::kProjectionWeakPx)
      sentence += (sentence.empty() ? "" : "; ") + weak.sentence + " (" +
                  pixels(weak.sigma_px, s.answer.camera->image_size) + " at infinity)";
  if (sentence.empty()) return std::nullopt;
  return finding(code::direction_weak, std::move(sentence));
}

// Largest standard deviation of the projection at infinity over the image.
double worst_px(const Solved& s) {
  double worst = 0;
  for (const double sigma : s.answer.projection.front().sigma_px.reshaped())
    if (sigma > worst) worst = sigma;
  return worst;
}

// Names the parts of the image without corners, and what is known there.
Result extrapolated(const Solved& s) {
  const ImageSize& size = s.answer.camera->image_size;
  const double worst = worst_px(s);
  const bool is_bad = worst > policy::kImageCornerShare * std::hypot(size.width, size.height);
  auto gaps = s.answer.seen.gaps();
  if (!gaps && !is_bad) return std::nullopt;
  std::string text = gaps ? *gaps : "the lens is extrapolated at the border of the image";
  text += " (sd of the projection there up to " + with_digits(worst, 2) + " px, if the lens " +
          (is_auto(*s.solution.options) ? "is like most" : "is one of model " + s.answer.model) +
          ")";
  return finding(code::extrapolated, std::move(text));
}

Result principal_point_untested(const Solved& s) {
  if (!(s.evidence.open_centre >= policy::kMuchLargerSd)) return std::nullopt;
  return finding(
      code::principal_point_untested,
      "the principal point is taken to be the centre of the image, and the views do not "
      "determine it: with model f+c the standard deviation of the focal length would be " +
          with_digits(s.evidence.open_centre, 2) + " times as large");
}

// Few poses do not show what they share: bends of the board that look like the lens.
Result few_views(const Solved& s) {
  const std::size_t count = s.answer.views.size();
  const std::size_t poses = s.solution.choice->posterior.information.num_samples();
  if (poses >= policy::kFewestComparedViews) return std::nullopt;
  return finding(code::few_views,
                 std::to_string(count) + (count == 1 ? " picture" : " pictures") +
                     (poses == count ? ""
                      : poses == 1   ? " of one pose of the board"
                                     : " of two poses of the board") +
                     ": the standard deviations rest on what is usual for lenses and boards; take "
                     "10, tilted in several directions");
}

// The shutter.

Result rows_displaced(const Solved& s) { return check_rows(s.solution.fit->bundle); }
Result rolling_shutter(const Solved& s) {
  return check_shutter(s.solution.fit->bundle, *s.solution.options);
}
Result readout_not_observable(const Solved& s) {
  return check_readout(s.answer.readout, s.solution.options->times_s);
}

// Model weak.

Result too_few_corners(const Solved& s) { return check_corner_count(*s.solution.fit); }
Result tilt_unknown(const Solved& s) { return check_tilts(s.answer); }
Result perspective_seen(const Solved& s) { return check_perspective(*s.solution.fit); }

enum class Of { all, perspective, weak };  // models
constexpr bool kAnswersOnly = true;        // skipped after a refusal

struct Check {
  Of models;
  Result (*run)(const Solved&);
  bool for_answers_only = false;
};

constexpr std::array kChecks = {
    Check{Of::all, too_few_inliers},
    Check{Of::weak, too_few_corners},
    Check{Of::weak, choice_refused, kAnswersOnly},
    Check{Of::perspective, tags_misplaced},
    Check{Of::perspective, tag_scale},
    Check{Of::perspective, wrong_target},
    Check{Of::perspective, unobservable},
    Check{Of::perspective, not_converged},
    Check{Of::all, noise_assumed},
    Check{Of::perspective, noise_understated},
    Check{Of::weak, noise_understated, kAnswersOnly},
    Check{Of::perspective, few_views, kAnswersOnly},
    Check{Of::perspective, model_too_small},
    Check{Of::perspective, board_bent},
    Check{Of::perspective, print_aspect},
    Check{Of::perspective, rows_displaced},
    Check{Of::perspective, rolling_shutter},
    Check{Of::perspective, readout_not_observable, kAnswersOnly},
    Check{Of::perspective, corners_rejected, kAnswersOnly},
    Check{Of::perspective, coefficients_correlated, kAnswersOnly},
    Check{Of::perspective, direction_weak},
    Check{Of::perspective, extrapolated, kAnswersOnly},
    Check{Of::perspective, principal_point_untested, kAnswersOnly},
    Check{Of::perspective, pole_in_image, kAnswersOnly},
    Check{Of::perspective, fold_in_image, kAnswersOnly},
    Check{Of::perspective, residuals_biased, kAnswersOnly},
    Check{Of::perspective, halves_disagree, kAnswersOnly},
    Check{Of::perspective, sources_disagree, kAnswersOnly},
    Check{Of::perspective, other_lens, kAnswersOnly},
    Check{Of::weak, tilt_unknown, kAnswersOnly},
    Check{Of::weak, perspective_seen, kAnswersOnly},
};

}  // namespace

void run_checks(const Solved& solved, std::vector<Finding>& findings) {
  const Of model = solved.solution.fit->has_perspective() ? Of::perspective : Of::weak;
  bool is_refused = std::ranges::any_of(findings, is_refusal);
  for (const Check& check : kChecks) {
    if (check.models != Of::all && check.models != model) continue;
    if (is_refused && check.for_answers_only) continue;
    Result result = check.run(solved);
    if (!result) continue;
    is_refused |= is_refusal(*result);
    findings.push_back(*std::move(result));
  }
}

}  // namespace tagcal::internal
