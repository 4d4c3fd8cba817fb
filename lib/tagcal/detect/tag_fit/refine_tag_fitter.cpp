#include "tagcal/detect/tag_fit/refine_tag_fitter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using namespace tag_parameter;

constexpr double kMinSpread = 0.3;  // a little more than the square's own
constexpr double kMaxSpread = 6;
constexpr double kMaxLogStep = 0.4;    // of the spread in one iteration
constexpr double kMaxStepPx = 0.7;     // of a corner in one iteration
constexpr double kRoundingPx = 1e-5;   // no corner needs a smaller step
constexpr double kSmallStep = 0.1;     // squared, in standard deviations
constexpr double kAtRest = 1;          // likewise, of one step of a corner
constexpr double kMaxSecondOrder = 2;  // squared, in sds of belief, of all bends of an order ..
constexpr double kMaxThirdOrder = 3.5;
constexpr double kStronger = 2;          // .. beyond which they may be so much larger, per order
constexpr double kMinContrast = 8;       // grey levels
constexpr double kMaxNoiseShare = 0.15;  // of the contrast, in what the model leaves over
constexpr double kMaxSdPx = 0.5;         // of a corner
constexpr double kLeastGain = 3e-4;      // squared, of a step's size over that of the one before
constexpr double kSecondOrder = 0.25;    // squared, of a step's residue over its square in spreads
constexpr double kNearPx = 0.25;         // of a corner, after which all rows are looked at
constexpr double kHeld = 1e18;           // the prior's weight of what is held at zero
constexpr double kPlaceSd = 0.15;        // of the start's homography, over a region: of places, ..
constexpr double kScaleSd = 0.05;        // .. of scales and turns, ..
constexpr double kPerspectiveSd = 0.03;  // .. of what changes these
constexpr double kWindowsPx[] = {9, 18,
                                 32};  // about one corner, that are looked at before the whole
constexpr int kMaxInWindow = 3;        // iterations in one of them
constexpr double kMaxGrowth = 1.7;     // of the variance, from the largest window to the region
constexpr int kFewRows = 16;
constexpr int kMaxRowStep = 6;
constexpr int kMaxComing = 4;    // iterations on few rows
constexpr double kPartsPx = 36;  // a tag that is large enough for parts, and ..
constexpr double kThirdOrderPx = 0.02;
constexpr double kThirdOrderSds = 8;  // .. how far bends of third order may move its corners
constexpr int kMinPixels = 64;
constexpr int kFreeIterations = 2;  // in which the set of pixels may change, ..
constexpr double kWider = 1.05;     // .. and later, where the spread has grown so much since

}  // namespace

TagFitter::TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options)
    : region_(region),
      options_(options),
      start_(start),
      scale_(region.scale),
      middle_(region.middle),
      model_(region.grid, region.scale, options.gamma) {}

// One step from the sums; false where it is not a number.
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
  // What the next step would do is known before it is made: it is of second order in this one, and
  // Gauss-Newton's own residue.
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
    // What else a few lines leave open may wander, once the corner rests.
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(*region_.corner);
    const auto by_corner = by.middleRows<2>(at);
    const Eigen::Matrix2d covariance = variance_ * by_corner * inverse.solve(by_corner.transpose());
    const Vector2d of_corner = moves.segment<2>(at);
    const double corner_size = of_corner.dot(covariance.inverse() * of_corner);
    left_over_ = corner_size_ < kAtRest ? corner_size : size;
    corner_size_ = corner_size;
  }
  const double move = move_px_;
  const double share = std::min({1.0, kMaxStepPx / std::max(1e-12, move),
                                 kMaxLogStep / std::max(1e-12, std::abs(change[kLogSpread]))});
  TagParameters next = model_.parameters() + share * change;
  // Of what this step leaves, as far as it goes.
  if (share == 1) variance_ = std::max(kBoxVariance, left / std::max(1, num_pixels_ - kCount));
  next[kLogSpread] = std::clamp(next[kLogSpread], std::log(kMinSpread), std::log(kMaxSpread));
  model_.set(next);
  if (row_step_ == 1 && window_px_ == 0) believe_bends();
  return true;
}

// Where bends are found that straighter lenses hardly make, they are believed to be any.
void TagFitter::believe_bends() {
  if (num_bends_ == 0 || is_strongly_bent_) return;
  const auto weighted = model_.parameters().cwiseAbs2().cwiseProduct(prior_);
  is_strongly_bent_ = weighted.segment<4>(kBend).sum() > kMaxSecondOrder ||
                      weighted.segment<8>(kBend + 4).sum() > kMaxThirdOrder;
  if (!is_strongly_bent_) return;
  prior_.segment<4>(kBend) /= kStronger * kStronger;
  prior_.segment<8>(kBend + 4) /= std::pow(kStronger, 4);
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
  const double largest = std::sqrt(fit.covariance_px2.diagonal().maxCoeff());
  const bool matches = left_over_ < kSmallStep && p[kGain] >= kMinContrast &&
                       fit.noise_levels < kMaxNoiseShare * p[kGain];
  if (!matches) return fit;
  const bool is_fixed = num_pixels_ >= kMinPixels && largest < kMaxSdPx;
  fit.status = is_fixed ? TagFitStatus::converged : TagFitStatus::too_small;
  return fit;
}

void TagFitter::set_prior(const TagParameters& start) {
  // About one corner, the lines that are seen may say nothing of a scale or of the perspective.
  prior_mean_.head<kLogSpread>() = start.head<kLogSpread>();
  const double far = 1 / (kPlaceSd * kPlaceSd), sides = 1 / (kScaleSd * kScaleSd);
  const double perspective = 1 / (kPerspectiveSd * kPerspectiveSd);
  prior_.head<kLogSpread>() << sides, sides, far, sides, sides, far, perspective, perspective;
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

// About one corner, from its nearest surroundings outwards.
bool TagFitter::open_windows() {
  // Nothing is seen of bends and of the perspective, and little of shifts.
  const int num_bends = std::exchange(num_bends_, 0);
  const TagParameters prior = prior_;
  prior_.segment<2>(kM3).setConstant(kHeld);
  prior_.segment<2>(kShift).setConstant(kHeld);
  for (const double window : kWindowsPx) {
    window_px_ = window;
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

// Steps on few rows.
bool TagFitter::come_near() {
  // What few rows about one corner leave open wanders.
  row_step_ = std::clamp(patch_.height / kFewRows, 1, region_.corner ? 2 : kMaxRowStep);
  if (row_step_ == 1) return true;
  for (int i = 0; i < (region_.corner ? 1 : kMaxComing); ++i) {
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
  if (region_.corner || num_bends_ == 0 || view_ || options_.is_whole || 2 * scale_ < kPartsPx)
    return false;
  const double third_order = third_order_px();
  if (third_order < kThirdOrderPx) return false;
  // Of all rows, from those that were looked at.
  TagInformation system = row_step_ / variance_ * information_;
  system.diagonal() += prior_;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 8> covariance = by * system.ldlt().solve(by.transpose());
  return third_order > kThirdOrderSds * std::sqrt(covariance.diagonal().maxCoeff());
}

TagFit TagFitter::iterate() {
  TagFit fit;
  for (int k = 1; k <= options_.max_iterations; ++k) {
    // From the third on, so that no pixel comes and goes with every step; but not while a strong
    // blur is still coming in, which lets what is not known be felt farther.
    are_spans_fixed_ = k > kFreeIterations && model_.spread() < kWider * spans_spread_;
    if (!are_spans_fixed_) spans_spread_ = model_.spread();
    collect();
    if (num_pixels_ < kMinPixels) {
      fit.status = TagFitStatus::too_small;
      return fit;
    }
    if (!step()) return fit;
    ++iterations_;
    if (left_over_ < kSmallStep) break;
  }
  return result();
}

TagFit TagFitter::fit() {
  TagParameters parameters;
  if (!start_parameters(parameters)) return {};
  set_prior(parameters);
  model_.set(parameters);
  if ((region_.corner && !open_windows()) || !come_near()) return {};
  TagFit near;
  for (std::size_t i = 0; i < 4; ++i) near.corners[i] = pixel(corner(i)).value_or(start_[i]);
  TagFit fit = iterate();
  // What is farther from the corner was taken for something else: without it.
  if (region_.corner && !is_like_window()) {
    model_.set(in_window_);
    window_px_ = kWindowsPx[std::size(kWindowsPx) - 1];
    fit = iterate();
    if (!is_like_window()) return {};
  }
  // A tag that is bent too much to converge is known as such from the steps near the start only.
  if (fit.status == TagFitStatus::converged) is_for_parts_ = is_bent_beyond_whole();
  return is_for_parts_ && fit.status != TagFitStatus::converged ? near : fit;
}

bool TagFitter::is_like_window() const { return variance_ < kMaxGrowth * window_variance_; }

}  // namespace tagcal::internal
