#include "tagcal/detect/tag_fit/tag_fitter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

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
constexpr double kNearPx = 0.25;       // numeric: after a smaller step all rows are used
constexpr double kHeld = 1e18;         // the prior's weight for parameters that are held
constexpr int kMaxInWindow = 3;        // iterations in one window
constexpr int kFewRows = 16;
constexpr int kMaxRowStep = 6;
constexpr int kMaxOnFewRows = 4;    // iterations
constexpr int kFreeIterations = 2;  // in which the set of pixels may change
constexpr double kWider = 1.05;     // numeric: growth of the spread after which it may change again

}  // namespace

TagFitter::TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options)
    : region_(region),
      options_(options),
      start_(start),
      scale_(region.scale),
      middle_(region.middle),
      model_(region.grid, region.scale, options.gamma) {}

// Makes one step from the sums; false if it is not finite.
bool TagFitter::step() {
  variance_ = std::max(kBoxVariance, squares_ / std::max(1, num_pixels_ - kCount));
  TagInformation system = information_;
  system.diagonal() += variance_ * prior_;
  const TagParameters right =
      gradient_ - variance_ * prior_.cwiseProduct(model_.parameters() - prior_mean_);
  const Eigen::LDLT<TagInformation> inverse(system);
  const TagParameters change = inverse.solve(right);
  if (!change.allFinite()) return false;
  const double left = squares_ - change.dot(2 * gradient_ - information_ * change);
  // The next step's size is estimated from this one: second derivatives make it of second order,
  // and Gauss-Newton's approximation leaves a constant share.
  const double size = change.dot(right) / variance_;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 1> moves = by * change;
  move_px_ = moves.cwiseAbs().maxCoeff();
  const double bent = kSecondOrder * (std::pow(move_px_ / model_.spread(), 2) +
                                      change[kLogSpread] * change[kLogSpread] +
                                      std::pow(change[kGain] / model_.parameters()[kGain], 2));
  left_over_ = std::max(bent, kLeastGain) * size;
  if (move_px_ < kRoundingPx) left_over_ = 0;
  if (region_.corner && row_step_ == 1) {
    // In a region of one corner only that corner must converge: the rest is poorly constrained.
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(*region_.corner);
    const auto by_corner = by.middleRows<2>(at);
    const Eigen::Matrix2d covariance = variance_ * by_corner * inverse.solve(by_corner.transpose());
    const Vector2d of_corner = moves.segment<2>(at);
    const double corner_size = of_corner.dot(covariance.inverse() * of_corner);
    left_over_ = corner_size_ < kCornerSettledSize ? corner_size : size;
    corner_size_ = corner_size;
  }
  const double move = move_px_;
  const double share = std::min({1.0, kMaxStepPx / std::max(kTiny, move),
                                 kMaxLogStep / std::max(kTiny, std::abs(change[kLogSpread]))});
  TagParameters next = model_.parameters() + share * change;
  // The linear model predicts the residuals after a whole step.
  if (share == 1) variance_ = std::max(kBoxVariance, left / std::max(1, num_pixels_ - kCount));
  next[kLogSpread] = std::clamp(next[kLogSpread], std::log(policy::kTagMinSpreadPx),
                                std::log(policy::kTagMaxSpreadPx));
  model_.set(next);
  if (row_step_ == 1 && window_px_ == 0) widen_prior_of_bends();
  return true;
}

// Widens the prior once if the bends are larger than most lenses make them.
void TagFitter::widen_prior_of_bends() {
  if (num_bends_ == 0 || is_strongly_bent_) return;
  const auto weighted = model_.parameters().cwiseAbs2().cwiseProduct(prior_);
  is_strongly_bent_ = weighted.segment<4>(kBend).mean() > policy::kTagStrongBends ||
                      weighted.segment<8>(kBend + 4).mean() > policy::kTagStrongBends;
  if (!is_strongly_bent_) return;
  prior_.segment<4>(kBend) /= policy::kTagStrongerBends * policy::kTagStrongerBends;
  prior_.segment<8>(kBend + 4) /= std::pow(policy::kTagStrongerBends, 4);
  left_over_ = 1;
}

TagFit TagFitter::result() const {
  TagFit fit;
  const TagParameters& p = model_.parameters();
  fit.iterations = iterations_;
  fit.num_pixels = num_pixels_;
  fit.noise_levels = std::sqrt(variance_);
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
  TagInformation system = information_ / variance_;
  system.diagonal() += prior_;
  const TagCornerJacobian by = corner_jacobian();
  fit.covariance_px2 = by * system.ldlt().solve(by.transpose());
  const bool matches = left_over_ < kConvergedSize && p[kGain] >= policy::kMinContrast &&
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
  prior_.segment<2>(kShift).setConstant(shift_sd > 0 ? 1 / (shift_sd * shift_sd) : kHeld);
  const double bend_sd = options_.bend_sd_per_px * scale_ / 2;
  const double twist_sd = options_.twist_sd_per_px2 * scale_ * scale_ / 6;
  num_bends_ = bend_sd > 0 && twist_sd > 0 && (!view_ || options_.is_rough) ? kNumBends : 0;
  prior_.segment<kNumBends>(kBend).setConstant(kHeld);
  if (num_bends_ == 0) return;
  prior_.segment<4>(kBend).setConstant(1 / (bend_sd * bend_sd));
  prior_.segment<8>(kBend + 4).setConstant(1 / (twist_sd * twist_sd));
}

// Fits windows of growing size about the region's corner.
bool TagFitter::fit_windows() {
  // Windows do not determine bends and perspective, and hardly shifts.
  const int num_bends = std::exchange(num_bends_, 0);
  const TagParameters prior = prior_;
  prior_.segment<2>(kM3).setConstant(kHeld);
  prior_.segment<2>(kShift).setConstant(kHeld);
  for (int quarters = 1; quarters <= 3; ++quarters) {
    window_px_ = quarters * policy::kTagInsidePx / 4;
    for (int i = 0; i < kMaxInWindow; ++i) {
      collect();
      if (num_pixels_ < kMinPixels || !step()) return false;
      if (move_px_ < kNearPx) break;
    }
  }
  num_bends_ = num_bends;
  prior_ = prior;
  in_window_ = model_.parameters();
  window_variance_ = variance_;
  window_px_ = 0;
  return true;
}

// Makes steps on few rows.
bool TagFitter::fit_few_rows() {
  // Few rows about one corner do not determine all parameters.
  row_step_ = std::clamp(patch_.height / kFewRows, 1, region_.corner ? 2 : kMaxRowStep);
  if (row_step_ == 1) return true;
  for (int i = 0; i < (region_.corner ? 1 : kMaxOnFewRows); ++i) {
    collect();
    if (num_pixels_ < kMinPixels) break;
    if (!step()) return false;
    ++iterations_;
    if (move_px_ < kNearPx) break;
  }
  is_for_parts_ = is_bent_beyond_whole();
  row_step_ = 1;
  return true;
}

bool TagFitter::is_bent_beyond_whole() const {
  if (region_.corner || num_bends_ == 0 || view_ || options_.is_whole) return false;
  // The information of all rows, from that of every row_step_-th.
  TagInformation system = row_step_ / variance_ * information_;
  system.diagonal() += prior_;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 8> covariance = by * system.ldlt().solve(by.transpose());
  return third_order_px() > policy::kTagThirdOrderSds * std::sqrt(covariance.diagonal().maxCoeff());
}

TagFit TagFitter::iterate() {
  TagFit fit;
  for (int k = 1; k <= options_.max_iterations; ++k) {
    // The set of pixels is fixed from the third iteration on, so that it does not alternate between
    // steps; but not while the blur still grows, because unknown surroundings then reach farther.
    are_spans_fixed_ = k > kFreeIterations && model_.spread() < kWider * spans_spread_;
    if (!are_spans_fixed_) spans_spread_ = model_.spread();
    collect();
    if (num_pixels_ < kMinPixels) {
      fit.status = TagFitStatus::too_small;
      return fit;
    }
    if (!step()) return fit;
    ++iterations_;
    if (left_over_ < kConvergedSize) break;
  }
  return result();
}

bool TagFitter::is_like_window() const {
  return variance_ < policy::kTagMaxVarianceGrowth * window_variance_;
}

TagFit TagFitter::fit() {
  TagParameters parameters;
  if (!start_parameters(parameters)) return {};
  set_prior(parameters);
  model_.set(parameters);
  if ((region_.corner && !fit_windows()) || !fit_few_rows()) return {};
  TagFit start_of_parts;
  for (std::size_t i = 0; i < 4; ++i)
    start_of_parts.corners[i] = pixel(corner(i)).value_or(start_[i]);
  if (is_for_parts_ && options_.lens_follows) return start_of_parts;
  TagFit fit = iterate();
  // Far from the corner the picture shows something else: fits the largest window alone.
  if (region_.corner && !is_like_window()) {
    model_.set(in_window_);
    window_px_ = 3 * policy::kTagInsidePx / 4;
    fit = iterate();
    if (!is_like_window()) return {};
  }
  // If the bends keep the fit from converging, the decision of the first steps stands.
  if (fit.status == TagFitStatus::converged) is_for_parts_ = is_bent_beyond_whole();
  return is_for_parts_ && fit.status != TagFitStatus::converged ? start_of_parts : fit;
}

}  // namespace tagcal::internal
