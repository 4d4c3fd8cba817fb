#include "tagcal/detect/refine_tag_fitter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace tag_parameter;

constexpr double kMinSpread = 0.3;  // a little more than the square's own
constexpr double kMaxSpread = 6;
constexpr double kMaxLogStep = 0.4;       // of the spread in one iteration
constexpr double kMaxStepPx = 0.7;        // of a corner in one iteration
constexpr double kRoundingPx = 1e-5;      // no corner needs a smaller step
constexpr double kSmallStep = 0.03;       // squared, in standard deviations
constexpr double kMinContrast = 8;        // grey levels
constexpr double kMaxNoiseShare = 0.15;   // of the contrast, in what the model leaves over
constexpr double kMaxSdPx = 0.5;          // of a corner
constexpr double kLeastGain = 1e-3;       // squared, of a step's size over that of the one before
constexpr double kHeld = 1e18;            // the prior's weight of what is held at zero
constexpr double kPlaneSd = 0.15;         // of the start's homography, over a region
constexpr double kWindowsPx[] = {9, 18};  // about one corner, that are looked at before the whole
constexpr int kManyRows = 24;
constexpr int kMinPixels = 64;
constexpr int kFreeIterations = 2;  // in which the set of pixels may change

}  // namespace

TagFitter::TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options)
    : region_(region),
      options_(options),
      start_(start),
      scale_(region.scale),
      middle_(region.middle),
      model_(region.grid, region.scale) {}

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
  // Gauss-Newton at a small residual: every step about the square of the one before. What the next
  // would do is known before it is made.
  const double size = change.dot(right) / variance_;
  left_over_ = std::max(size * size * size / (step_size_ * step_size_), kLeastGain * size);
  step_size_ = size;
  const TagCornerJacobian by = corner_jacobian();
  const Eigen::Matrix<double, 8, 1> moves = by * change;
  const double move = moves.cwiseAbs().maxCoeff();
  if (move < kRoundingPx) left_over_ = 0;
  if (region_.corner && row_step_ == 1) {
    // What else a few lines leave open may wander.
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(*region_.corner);
    const auto by_corner = by.middleRows<2>(at);
    const Eigen::Matrix2d covariance = variance_ * by_corner * inverse.solve(by_corner.transpose());
    const Vector2d of_corner = moves.segment<2>(at);
    left_over_ = std::min(left_over_, of_corner.dot(covariance.inverse() * of_corner));
  }
  const double share = std::min({1.0, kMaxStepPx / std::max(1e-12, move),
                                 kMaxLogStep / std::max(1e-12, std::abs(change[kLogSpread]))});
  TagParameters next = model_.parameters() + share * change;
  next[kLogSpread] = std::clamp(next[kLogSpread], std::log(kMinSpread), std::log(kMaxSpread));
  model_.set(next);
  return true;
}

Vector2d TagFitter::straight_corner(std::size_t i) const {
  const TagParameters& p = model_.parameters();
  const Vector2d& on_tag = region_.corners_on_tag[i];
  const auto line = [&](int row, double at) {
    Vector3d result = p.segment<3>(row);
    result.head<2>() -= at * p.segment<2>(kM3);
    result.z() -= at;
    return result;
  };
  return line(kM1, on_tag.x()).cross(line(kM2, on_tag.y())).hnormalized();
}

// Without what the lens, if known, does.
Vector2d TagFitter::corner(std::size_t i) const {
  const TagParameters& p = model_.parameters();
  const Vector2d bent = straight_corner(i);
  Vector2d place = bent;
  for (int k = 0; k < 5; ++k)
    place = bent - bend_basis(place.x(), place.y()) * p.segment<kNumBends>(kBend);
  return place;
}

TagCornerJacobian TagFitter::corner_jacobian() const {
  const TagParameters& p = model_.parameters();
  TagCornerJacobian result = TagCornerJacobian::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    if (!is_in_region(i)) continue;
    const double u = region_.corners_on_tag[i].x(), v = region_.corners_on_tag[i].y();
    const Vector2d place = corner(i);
    const Eigen::Matrix<double, kNumBends, 1> bend = p.segment<kNumBends>(kBend);
    const BendBasis basis = bend_basis(place.x(), place.y());
    const Vector2d bent = place + basis * bend;
    Eigen::Matrix2d across;
    across.row(0) = p.segment<2>(kM1) - u * p.segment<2>(kM3);
    across.row(1) = p.segment<2>(kM2) - v * p.segment<2>(kM3);
    Eigen::Matrix<double, 2, kCount> by = Eigen::Matrix<double, 2, kCount>::Zero();
    by.row(0).segment<3>(kM1) = -bent.homogeneous();
    by.row(1).segment<3>(kM2) = -bent.homogeneous();
    by.row(0).segment<2>(kM3) = u * bent;
    by.row(1).segment<2>(kM3) = v * bent;
    by = (across.inverse() * by).eval();
    by.middleCols<kNumBends>(kBend) -= basis;
    Eigen::Matrix2d straight;        // bent place by place
    constexpr double kDelta = 1e-4;  // exact for cubics but for its square
    for (int k = 0; k < 2; ++k) {
      const Vector2d d = kDelta * Vector2d::Unit(k);
      const Vector2d more = place + d, less = place - d;
      straight.col(k) =
          Vector2d::Unit(k) +
          (bend_basis(more.x(), more.y()) - bend_basis(less.x(), less.y())) * bend / (2 * kDelta);
    }
    Eigen::Matrix2d pixels = scale_ * Eigen::Matrix2d::Identity();
    if (view_) pixels = view_->pixel_by_place(place).value_or(pixels);
    result.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = pixels * straight.inverse() * by;
  }
  return result;
}

TagFit TagFitter::result(int iterations) const {
  TagFit fit;
  const TagParameters& p = model_.parameters();
  fit.iterations = iterations;
  fit.num_pixels = num_pixels_;
  fit.noise_levels = std::sqrt(variance_);
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

bool TagFitter::is_in_region(std::size_t corner) const {
  return !region_.corner || *region_.corner == corner;
}

double TagFitter::third_order_px() const {
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d place = corner(i);
    const Vector2d moved =
        bend_basis(place.x(), place.y()).rightCols<8>() * model_.parameters().segment<8>(kBend + 4);
    largest = std::max(largest, scale_ * moved.norm());
  }
  return largest;
}

void TagFitter::set_prior(const TagParameters& start) {
  // About one corner, the lines that are seen may say nothing of a scale or of the perspective.
  prior_mean_.head<kLogSpread>() = start.head<kLogSpread>();
  prior_.head<kLogSpread>().setConstant(1 / (kPlaneSd * kPlaneSd));
  const double bend_sd = options_.bend_sd_per_px * scale_ / 2;
  const double twist_sd = options_.twist_sd_per_px2 * scale_ * scale_ / 6;
  num_bends_ = bend_sd > 0 && twist_sd > 0 && !view_ ? kNumBends : 0;
  prior_.segment<kNumBends>(kBend).setConstant(kHeld);
  if (num_bends_ == 0) return;
  prior_.segment<4>(kBend).setConstant(1 / (bend_sd * bend_sd));
  prior_.segment<8>(kBend + 4).setConstant(1 / (twist_sd * twist_sd));
}

TagFit TagFitter::fit() {
  TagParameters parameters;
  if (!start_parameters(parameters)) return {};
  set_prior(parameters);
  model_.set(parameters);
  if (region_.corner) {
    for (const double window : kWindowsPx) {
      window_px_ = window;
      collect();
      if (num_pixels_ < kMinPixels || !step()) return {};
    }
    window_px_ = 0;
    step_size_ = 1e-9;  // of another problem
  }
  for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
    // From the third on, so that no pixel comes and goes with every step.
    are_spans_fixed_ = iteration > kFreeIterations;
    // The first only comes near.
    row_step_ = iteration == 1 && patch_.height >= kManyRows ? 2 : 1;
    collect();
    if (num_pixels_ < kMinPixels) {
      TagFit fit;
      fit.status = TagFitStatus::too_small;
      return fit;
    }
    if (!step()) return {};
    if (left_over_ < kSmallStep || iteration == options_.max_iterations) return result(iteration);
  }
  return {};
}

}  // namespace tagcal
