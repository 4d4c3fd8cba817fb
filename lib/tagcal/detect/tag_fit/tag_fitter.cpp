#include "tagcal/detect/tag_fit/tag_fitter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using namespace tag_parameter;

constexpr double kConvergedSize = policy::kConvergedSds * policy::kConvergedSds;
constexpr int kMinPixels = 64;            // of a fit, about twice its parameters
constexpr double kCornerSettledSize = 1;  // squared, in sds: then the region's only corner decides
constexpr double kMaxLogStep = 0.4;       // numeric: largest step of the spread's logarithm
constexpr double kMaxStepPx = 0.7;        // numeric: largest step of a corner
constexpr double kRoundingPx = 1e-5;      // numeric: no corner needs a smaller step
constexpr double kTiny = 1e-12;           // numeric: keeps a step of zero from dividing by it
// Expected size of the next step over the last one's, squared: at least, and in units of the last
// step's square (px and blur in spreads, gain relative).
constexpr double kLeastGain = 3e-4;    // numeric: Gauss-Newton's own rate of convergence
constexpr double kSecondOrder = 0.25;  // numeric: rate of convergence by second derivatives
constexpr double kShiftEndPx = 0.01;   // numeric: a tenth of what the corners of a large tag claim
constexpr double kHeld = 1e18;         // the prior's weight for parameters that are held
constexpr int kMaxInWindow = 3;        // iterations in one window
constexpr int kFewRows = 16;
constexpr int kMaxRowStep = 6;
constexpr int kMaxOnFewRows = 4;      // iterations
constexpr int kFreeIterations = 2;    // in which the set of pixels may change
constexpr double kSmallStepPx = 0.1;  // numeric: a step against the reach of lines, 3 px and more
constexpr double kWider = 1.05;  // numeric: growth of the spread after which it may change again
constexpr double kFirstDamping = 0.05;  // numeric: Levenberg-Marquardt's, after a first bad step
constexpr double kDampingFactor = 5;    // numeric: growth after a bad step, fall after a good one
// Variance of a place in a smoothed picture over that by independent residuals: along a border the
// filter leaves the noise's mean, whereas it takes 1 - (3/8)^2 of a pixel's variance; across, a
// border of spread 0.9 px keeps 0.78 of its energy.
constexpr double kSmoothVariance = 0.78 * 64 / 9;  // numeric: filter's gain, as above
constexpr double kOtherPixels = 1.5;  // numeric: growth of the mean square by other pixels

// Half side of the window about a corner in a part of `quarters` quarters of the region.
double window_px(int quarters) { return quarters * policy::kTagInsidePx / 4; }

}  // namespace

TagFitter::TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options,
                     const BorderShift* known_shift)
    : region_(region),
      options_(options),
      known_shift_(known_shift),
      start_(start),
      model_(region.grid, region.scale, options.processing.gamma) {}

// Windows of growing size about the region's corner, then few rows. A window does not determine
// bends and perspective, and hardly shifts.
std::vector<FitStage> TagFitter::rough_stages() const {
  std::vector<FitStage> stages;
  if (region_.corner) {
    const int last = is_quick() || options_.is_near ? 2 : 3;
    for (int quarters = options_.is_near ? last : 1; quarters <= last; ++quarters)
      stages.push_back({.max_steps = options_.is_near ? 1 : kMaxInWindow,
                        .is_rough = true,
                        .window_px = window_px(quarters),
                        .is_affine = true});
    if (options_.is_near || is_quick()) return stages;
  }
  if (options_.rest) return stages;
  // Few rows about one corner do not determine all parameters.
  const int row_step = std::clamp(patch_.height / kFewRows, 1, region_.corner ? 2 : kMaxRowStep);
  const int max_steps = region_.corner ? 1 : kMaxOnFewRows;
  if (row_step > 1)
    stages.push_back({.max_steps = max_steps, .is_rough = true, .row_step = row_step});
  return stages;
}

// Takes back a step after which the squares are larger, and damps the next one: a border sharper
// than a pixel leaves Gauss-Newton's linear model within half a pixel. Pixels that the step clips
// have no square: of the same pixels the sum counts, of others the mean.
void TagFitter::damp_if_worse(const std::optional<TagSums>& before, bool of_same_pixels) {
  const auto is_worse = [&] {
    return of_same_pixels ? sums_.squares > before->squares
                          : sums_.mean_square() > kOtherPixels * before->mean_square();
  };
  if (before && is_worse()) {
    damping_ = std::max(kFirstDamping, kDampingFactor * damping_);
    sums_ = *before;
    model_.set(sums_.at);
  } else if (damping_ > kFirstDamping / kDampingFactor) {
    damping_ /= kDampingFactor;
  }
}

// Makes the steps of a stage.
StageEnd TagFitter::run(const FitStage& stage) {
  stage_ = stage;
  double selected_spread = 0;  // the spread for which the pixels were selected
  std::optional<TagSums> before;
  damping_ = 0;
  for (int k = 1; k <= stage.max_steps; ++k) {
    // The set of pixels is fixed after a small step or two others, so that it does not alternate
    // between steps; but not while the blur still grows: unknown surroundings then reach farther.
    const bool was_selection_kept = is_selection_kept_;
    is_selection_kept_ = !stage.is_rough &&
                         k > (last_.move_px < kSmallStepPx ? 1 : kFreeIterations) &&
                         model_.spread() < kWider * selected_spread;
    if (!is_selection_kept_) selected_spread = model_.spread();
    collect();
    if (sums_.num_pixels < kMinPixels) return StageEnd::too_few_pixels;
    damp_if_worse(before, was_selection_kept && is_selection_kept_);
    before = sums_;
    const auto step = this->step();
    if (!step) return StageEnd::not_finite;
    last_ = *step;
    model_.set(last_.next);
    ++iterations_;
    if (!stage.is_rough && stage.window_px == 0 && widen_prior_of_bends()) last_.left_over = 1;
    if (stage.is_rough ? last_.move_px < stage.end_px : last_.left_over < kConvergedSize) break;
  }
  return StageEnd::reached;
}

TagParameters TagFitter::prior_weights() const {
  TagParameters weights = prior_;
  if (!stage_.is_affine) return weights;
  weights.segment<2>(kM3).setConstant(kHeld);
  weights.segment<2>(kShift).setConstant(kHeld);
  return weights;
}

// Expected size of the step after a step, over its own: second derivatives make it of second order,
// and Gauss-Newton's approximation leaves a constant share.
double TagFitter::share_left(const TagParameters& change, double move_px) const {
  if (move_px < kRoundingPx) return 0;
  const double bent = kSecondOrder * (std::pow(move_px / model_.spread(), 2) +
                                      change[kLogSpread] * change[kLogSpread] +
                                      std::pow(change[kGain] / model_.parameters()[kGain], 2));
  return std::max(bent, kLeastGain);
}

// The step from the sums; no value if it is not finite.
std::optional<FitStep> TagFitter::step() const {
  const auto& [parameters, information, gradient, squares, num_pixels] = sums_;
  FitStep result;
  const double variance = sums_.variance(squares);
  const TagParameters weights = prior_weights();
  TagInformation system = information;
  system.diagonal() *= 1 + damping_;
  system.diagonal() += variance * weights;
  const TagParameters right = gradient - variance * weights.cwiseProduct(parameters - prior_mean_);
  const TagSystem inverse = solvable(system);
  const TagParameters change = inverse.solve(right);
  if (!change.allFinite()) return std::nullopt;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 1> moves = by * change;
  result.move_px = moves.cwiseAbs().maxCoeff();
  const double size = change.dot(right) / variance;
  result.left_over = size * (share_left(change, result.move_px) + damping_ / (1 + damping_));
  result.corner_size = last_.corner_size;
  if (region_.corner && stage_.row_step == 1) {
    // In a region of one corner only that corner must converge: the rest is poorly constrained.
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(*region_.corner);
    const auto by_corner = by.middleRows<2>(at);
    const Eigen::Matrix2d covariance = variance * by_corner * inverse.solve(by_corner.transpose());
    const Vector2d of_corner = moves.segment<2>(at);
    result.corner_size =
        std::pow(1 + damping_, 2) * of_corner.dot(covariance.inverse() * of_corner);
    result.left_over = last_.corner_size < kCornerSettledSize ? result.corner_size : size;
  }
  const double share = std::min({1.0, kMaxStepPx / std::max(kTiny, result.move_px),
                                 kMaxLogStep / std::max(kTiny, std::abs(change[kLogSpread]))});
  result.next = parameters + share * change;
  result.next[kLogSpread] = std::clamp(result.next[kLogSpread], std::log(policy::kTagMinSpreadPx),
                                       std::log(policy::kTagMaxSpreadPx));
  // The linear model predicts the residuals after a whole step.
  const double left = squares - change.dot(2 * gradient - information * change);
  result.variance = share == 1 ? sums_.variance(left) : variance;
  return result;
}

// Widens the prior once if the bends are larger than most lenses make them.
bool TagFitter::widen_prior_of_bends() {
  if (!has_bends_ || is_prior_widened_) return false;
  const auto weighted = model_.parameters().cwiseAbs2().cwiseProduct(prior_);
  is_prior_widened_ = weighted.segment<4>(kBend).mean() > policy::kTagStrongBends ||
                      weighted.segment<8>(kBend + 4).mean() > policy::kTagStrongBends;
  if (!is_prior_widened_) return false;
  prior_.segment<4>(kBend) /= policy::kTagStrongerBends * policy::kTagStrongerBends;
  prior_.segment<8>(kBend + 4) /= std::pow(policy::kTagStrongerBends, 4);
  return true;
}

TagSystem TagFitter::posterior(double times) const {
  TagInformation system = times * sums_.information / last_.variance;
  system.diagonal() += prior_;
  return solvable(system);
}

TagFit TagFitter::result(StageEnd end) const {
  TagFit fit;
  if (end == StageEnd::too_few_pixels) fit.status = TagFitStatus::too_small;
  if (end != StageEnd::reached) return fit;
  const TagParameters& p = model_.parameters();
  fit.iterations = iterations_;
  Eigen::Map<TagRest>(fit.rest.data()) = p.tail<kNumRest>();
  fit.num_pixels = sums_.num_pixels;
  fit.noise_levels = std::sqrt(last_.variance);
  fit.shift_px = p.segment<2>(kShift);
  fit.black = p[kBlack];
  fit.white = p[kBlack] + p[kGain];
  fit.blur_px = std::sqrt(std::max(0.0, std::pow(model_.spread(), 2) - kBoxVariance));
  for (std::size_t i = 0; i < 4; ++i) {
    if (!is_in_region(i)) continue;
    const auto at = pixel(corner(i));
    if (!at) return fit;
    fit.corners[i] = *at;
  }
  const TagCornerJacobian by = corner_jacobian();
  fit.covariance_px2 =
      (is_smooth_ ? kSmoothVariance : noise_factor_) * by * posterior(1).solve(by.transpose());
  const bool matches = last_.left_over < kConvergedSize && p[kGain] >= policy::kMinContrast &&
                       fit.noise_levels < policy::kTagMaxNoiseShare * p[kGain];
  if (!matches) return fit;
  fit.status = TagFitStatus::converged;
  return fit;
}

void TagFitter::set_prior(const TagParameters& start) {
  // The lines about one corner may not determine a scale or the perspective.
  prior_mean_.head<kLogSpread>() = start.head<kLogSpread>();
  const auto weight = [](double sd) { return 1 / (sd * sd); };
  const double scale = weight(policy::kTagScaleSd);
  const double perspective = weight(policy::kTagPerspectiveSd);
  prior_.head<kLogSpread>() << scale, scale, scale, scale, scale, scale, perspective, perspective;
  const double shift_sd = options_.shift_sd_px;
  prior_.segment<2>(kShift).setConstant(shift_sd > 0 ? weight(shift_sd) : kHeld);
  if (known_shift_) {
    prior_mean_.segment<2>(kShift) = known_shift_->px;
    prior_.segment<2>(kShift) = known_shift_->weights;
  }
  const double bend_sd = options_.bend_sd_per_px * region_.scale / 2;
  const double twist_sd = options_.twist_sd_per_px2 * region_.scale * region_.scale / 6;
  has_bends_ = bend_sd > 0 && twist_sd > 0 && (!view_ || options_.is_rough);
  prior_.segment<kNumBends>(kBend).setConstant(kHeld);
  if (!has_bends_) return;
  prior_.segment<4>(kBend).setConstant(1 / (bend_sd * bend_sd));
  prior_.segment<8>(kBend + 4).setConstant(1 / (twist_sd * twist_sd));
}

bool TagFitter::is_bent_beyond_whole() const {
  if (region_.corner || !has_bends_ || view_ || options_.is_whole) return false;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 8> covariance =
      by * posterior(stage_.row_step).solve(by.transpose());
  return third_order_px() > policy::kTagThirdOrderSds * std::sqrt(covariance.diagonal().maxCoeff());
}

TagFit TagFitter::fit_by(const FitStage& stage) {
  const StageEnd end = run(stage);
  noise_factor_ = 1;
  if (end == StageEnd::reached && last_.left_over < kConvergedSize) {
    if (may_need_light()) admit_light();
    // The last step may have been one of some standard deviations, which all residuals share.
    noise_factor_ = noise_factor();
    if (noise_factor_ > 1 && sums_.at != model_.parameters()) {
      collect();
      noise_factor_ = noise_factor();
    }
  }
  return result(end);
}

// Clipped overshoot has to be known to undo it: one more fit has that of the model.
TagFit TagFitter::fit_last(const FitStage& stage) {
  const TagFit fit = fit_by(stage);
  if (fit.status != TagFitStatus::converged || !unsharpened_ || !unsharpened_->has_bounds())
    return fit;
  replace_bounds();
  return fit_by(stage);
}

std::optional<BorderShift> TagFitter::border_shift() {
  if (options_.shift_sd_px <= 0) return BorderShift{Vector2d::Zero(), Vector2d::Constant(kHeld)};
  if (!start_fit()) return std::nullopt;
  const int row_step = std::clamp(patch_.height / kFewRows, 1, kMaxRowStep);
  const StageEnd end = run({.max_steps = 2 * kMaxOnFewRows,
                            .is_rough = true,
                            .row_step = row_step,
                            .end_px = kShiftEndPx});
  if (end != StageEnd::reached || last_.move_px > kShiftEndPx) return std::nullopt;
  if (may_need_light()) admit_light();
  const Eigen::Matrix<double, kCount, 2> columns =
      posterior(1).solve(TagInformation::Identity().middleCols<2>(kShift));
  const Eigen::Matrix2d covariance = columns.middleRows<2>(kShift);
  return BorderShift{model_.parameters().segment<2>(kShift), covariance.inverse().diagonal()};
}

TagFit TagFitter::corners_so_far() const {
  TagFit fit;
  for (std::size_t i = 0; i < 4; ++i) fit.corners[i] = pixel(corner(i)).value_or(start_[i]);
  return fit;
}

TagFit TagFitter::fit() {
  if (!start_fit()) return {};
  TagParameters parameters = model_.parameters();
  double window_variance = 1;
  for (const FitStage& stage : rough_stages()) {
    const StageEnd end = run(stage);
    if (end == StageEnd::not_finite) return {};
    if (stage.window_px > 0) {
      if (end == StageEnd::too_few_pixels) return result(end);
      parameters = model_.parameters();
      window_variance = last_.variance;
    } else {
      is_for_parts_ = is_bent_beyond_whole();
    }
  }
  const TagFit start_of_parts = corners_so_far();
  if (is_for_parts_ && options_.lens_follows) return start_of_parts;
  const auto is_like_window = [&] {
    return last_.variance < policy::kTagMaxVarianceGrowth * window_variance;
  };
  const FitStage last{.max_steps = options_.max_iterations,
                      .window_px = is_quick() ? window_px(2) : 0,
                      .row_step = std::max(1, options_.row_step)};
  TagFit fit = fit_last(last);
  // Pixels sample a border of half the usual spread too coarsely: two fifths of its spectrum,
  // exp(-(pi spread)^2 / 2), are left at half the sampling rate.
  if (fit.status == TagFitStatus::not_converged && model_.spread() < policy::kUsualSpreadPx / 2) {
    smooth();
    fit = fit_by(last);
  }
  // Far from the corner the picture shows something else: fits the largest window alone.
  if (region_.corner && !is_quick() && !is_like_window()) {
    model_.set(parameters);
    fit = fit_by({.max_steps = options_.max_iterations, .window_px = window_px(3)});
    if (!is_like_window()) return {};
  }
  // If the bends keep the fit from converging, the decision of the first steps stands.
  if (fit.status == TagFitStatus::converged) is_for_parts_ = is_bent_beyond_whole();
  return is_for_parts_ && fit.status != TagFitStatus::converged ? start_of_parts : fit;
}

}  // namespace tagcal::internal
