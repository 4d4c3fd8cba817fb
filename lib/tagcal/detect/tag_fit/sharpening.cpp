#include "tagcal/detect/tag_fit/sharpening.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tagcal::internal {
namespace {

constexpr double kKernelRadii = 3;  // numeric: of a Gaussian; 0.3 % is beyond
constexpr double kMarginRadii = 6;  // numeric: the inverse is a sum of ever wider Gaussians
constexpr double kLeft = 1e-3;      // numeric: share of the overshoot that the iteration may leave

// Weights of a Gaussian mean at 0, 1, .. pixels.
std::vector<float> half_gaussian(double radius_px) {
  std::vector<float> weights;
  double sum = 0;
  for (int i = 0; i <= std::ceil(kKernelRadii * radius_px); ++i) {
    weights.push_back(static_cast<float>(std::exp(-i * i / (2 * radius_px * radius_px))));
    sum += (i == 0 ? 1 : 2) * weights.back();
  }
  for (float& weight : weights) weight /= static_cast<float>(sum);
  return weights;
}

// Weighted means of columns and rows; beyond the outermost pixels they continue.
PixelLevels smoothed(const PixelLevels& levels, const std::vector<float>& weights) {
  const auto nearest = [](Eigen::Index i, Eigen::Index count) {
    return std::clamp<Eigen::Index>(i, 0, count - 1);
  };
  const auto reach = static_cast<Eigen::Index>(weights.size()) - 1;
  PixelLevels down = weights[0] * levels;
  for (Eigen::Index y = 0; y < levels.rows(); ++y)
    for (Eigen::Index i = 1; i <= reach; ++i)
      down.row(y) +=
          weights[static_cast<std::size_t>(i)] *
          (levels.row(nearest(y - i, levels.rows())) + levels.row(nearest(y + i, levels.rows())));
  PixelLevels result(levels.rows(), levels.cols());
  Eigen::Array<float, 1, Eigen::Dynamic> wide(levels.cols() + 2 * reach);
  for (Eigen::Index y = 0; y < levels.rows(); ++y) {
    wide << down.row(y).head<1>().replicate(1, reach), down.row(y),
        down.row(y).tail<1>().replicate(1, reach);
    result.row(y) = weights[0] * down.row(y);
    for (Eigen::Index i = 1; i <= reach; ++i)
      result.row(y) +=
          weights[static_cast<std::size_t>(i)] *
          (wide.segment(reach - i, levels.cols()) + wide.segment(reach + i, levels.cols()));
  }
  return result;
}

}  // namespace

template <typename T>
UnsharpenedPart::UnsharpenedPart(const ImageView<T>& image, const PixelBox& part,
                                 const Sharpen& sharpen)
    : full_(std::numeric_limits<T>::max()), size_(part.size), sharpen_(sharpen) {
  const int margin = static_cast<int>(std::ceil(kMarginRadii * sharpen.radius_px));
  const int left = std::max(0, part.left - margin), top = std::max(0, part.top - margin);
  const int right = std::min(image.width(), part.left + part.size.width + margin);
  const int bottom = std::min(image.height(), part.top + part.size.height + margin);
  seen_.resize(bottom - top, right - left);
  for (int y = top; y < bottom; ++y)
    seen_.row(y - top) =
        Eigen::Map<const Eigen::Array<T, 1, Eigen::Dynamic>>(image.row(y) + left, right - left)
            .template cast<float>();
  top_ = part.top - top;
  left_ = part.left - left;
  is_bound_ = seen_ <= 0 || seen_ >= full_;
  is_held_.setConstant(seen_.rows(), seen_.cols(), false);
  levels_ = seen_;
  solve();
}

template UnsharpenedPart::UnsharpenedPart(const ImageView8&, const PixelBox&, const Sharpen&);
template UnsharpenedPart::UnsharpenedPart(const ImageView16&, const PixelBox&, const Sharpen&);

// Richardson's iteration: of gains from 1 to 1 + amount it leaves amount / (2 + amount) of an
// error.
void UnsharpenedPart::solve() {
  const double amount = sharpen_.amount, left_over = amount / (2 + amount);
  const std::vector<float> weights = half_gaussian(sharpen_.radius_px);
  const auto a = static_cast<float>(amount), step = static_cast<float>(2 / (2 + amount));
  for (double error = 1; error > kLeft; error *= left_over)
    levels_ +=
        is_held_.select(0, step * (seen_ - (1 + a) * levels_ + a * smoothed(levels_, weights)));
}

// The least, or most, levels that neighbours allow to bounds.
PixelLevels UnsharpenedPart::bounds() const {
  const auto a = static_cast<float>(sharpen_.amount);
  return (seen_ + a * smoothed(levels_, half_gaussian(sharpen_.radius_px))) / (1 + a);
}

std::vector<float> UnsharpenedPart::levels() const {
  const auto sign = (seen_ > 0).cast<float>() * 2 - 1;
  const PixelLevels all = is_bound_.select(bounds() + beyond() * sign, levels_);
  const PixelLevels part = all.block(top_, left_, size_.height, size_.width);
  return {part.data(), part.data() + part.size()};
}

void UnsharpenedPart::replace_bounds(const std::vector<float>& levels) {
  const PixelLevels least = bounds();
  // The light was in the range before it was sharpened.
  const PixelLevels given =
      Eigen::Map<const PixelLevels>(levels.data(), size_.height, size_.width).max(0).min(full_);
  const auto part = [&](auto& all) { return all.block(top_, left_, size_.height, size_.width); };
  const auto is_beyond = (part(seen_) > 0).select(given > part(least), given < part(least));
  part(is_held_) = part(is_bound_) && is_beyond;
  part(levels_) = part(is_held_).select(given, part(levels_));
  solve();
}

double mean_log_gain(const Sharpen& sharpen) {
  constexpr int kNodes = 24;  // numeric: of the mean, along each axis
  const std::vector<float> weights = half_gaussian(sharpen.radius_px);
  std::array<double, kNodes> mean{};  // gain of the Gaussian mean along an axis
  for (int k = 0; k < kNodes; ++k) {
    const double turn = std::numbers::pi * (2 * k + 1) / (2 * kNodes);
    for (std::size_t i = 0; i < weights.size(); ++i)
      mean[k] += (i == 0 ? 1 : 2) * weights[i] * std::cos(turn * static_cast<double>(i));
  }
  double sum = 0;
  for (const double x : mean)
    for (const double y : mean) sum += std::log1p(sharpen.amount * (1 - x * y));
  return sum / (kNodes * kNodes);
}

}  // namespace tagcal::internal
