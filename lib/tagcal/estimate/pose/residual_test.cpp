#include "tagcal/estimate/pose/residual_test.hpp"
#include "tagcal/estimate/policy/policy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

namespace tagcal::internal {
namespace {

// RMS distance of the pixels from their centre.
double size_px(std::span<const Eigen::Vector2d> pixels) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double square = 0;
  for (const Eigen::Vector2d& p : pixels) {
    sum += p - pixels.front();
    square += (p - pixels.front()).squaredNorm();
  }
  const auto n = static_cast<double>(pixels.size());
  return std::sqrt(std::max(0.0, square / n - (sum / n).squaredNorm()));
}

constexpr double kOutlierSquare = policy::kOutlierSigmas * policy::kOutlierSigmas;

bool is_self_estimated(const NoiseLevel& noise) { return !noise.known && !noise.assumed; }

// The median of n such squares has a relative standard deviation of 1 / (ln 2 sqrt(n)). The margin
// keeps points that are inliers by the noise of their own residuals.
double largest_by_median(bool self_estimated, std::span<const double> squares) {
  constexpr double kMedianSpread = 1.44;  // numeric: 1 / ln 2
  const auto n = static_cast<double>(squares.size());
  const double margin =
      self_estimated ? 1 + policy::kQuantile1e3 * kMedianSpread / std::sqrt(n) : 1;
  return margin * kOutlierSquare * robust_variance(squares);
}

}  // namespace

ResidualTest residual_test(const PoseProblem& problem, const NoiseLevel& noise,
                           std::span<const double> squares, int num_parameters) {
  const double cost = std::accumulate(squares.begin(), squares.end(), 0.0);
  const double largest = *std::max_element(squares.begin(), squares.end());
  const double freedom = 2 * static_cast<double>(squares.size()) - num_parameters;
  const double variance = noise.sigma_px * noise.sigma_px;
  const double largest_chi_square = chi_square_quantile(freedom, policy::kSignificant);
  const bool self_estimated = is_self_estimated(noise);
  if (!self_estimated && largest <= kOutlierSquare * variance &&
      cost <= largest_chi_square * variance)
    return ResidualTest::consistent;
  const bool no_outlier = squares.size() < policy::kEnoughForMedian ||
                          (!self_estimated && largest <= kOutlierSquare * variance) ||
                          largest <= largest_by_median(self_estimated, squares);
  const double rms = std::sqrt(cost / static_cast<double>(squares.size()));
  const bool is_small = noise.known
                            ? cost <= kOutlierSquare * freedom * variance
                            : rms <= policy::kLargestNoiseOfImage * size_px(problem.view().pixels);
  if (!no_outlier || !is_small) return ResidualTest::inconsistent;
  return self_estimated ? ResidualTest::consistent : ResidualTest::noisy;
}

void NeighbourCorrelation::add(std::span<const Eigen::Vector2d> pixels,
                               std::span<const Eigen::Vector2d> residuals) {
  const std::size_t n = pixels.size();
  if (n < 2) return;
  num_points_ += n;
  // From left to right, so that the search ends where columns are farther than the nearest point.
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(pixels[i].x(), i); });
  for (std::size_t at = 0; at < n; ++at) {
    const Eigen::Vector2d& pixel = pixels[order[at]];
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0;
    const auto compare = [&](std::size_t i) {
      const Eigen::Vector2d d = pixels[i] - pixel;
      const double square = d.squaredNorm();
      if (square < least) std::tie(least, nearest) = std::pair(square, i);
      return d.x() * d.x() < least;
    };
    for (std::size_t i = at; i > 0 && compare(order[i - 1]);) --i;
    for (std::size_t i = at + 1; i < n && compare(order[i]);) ++i;
    product_ += residuals[order[at]].dot(residuals[nearest]);
    square_ += residuals[order[at]].squaredNorm();
  }
}

bool spatially_correlated(std::span<const Eigen::Vector2d> pixels,
                          std::span<const Eigen::Vector2d> residuals) {
  constexpr double kRoundingPx = 1e-9;  // numeric: exact pixels and poses leave 1e-11
  const bool is_rounding = std::ranges::all_of(
      residuals, [&](const Eigen::Vector2d& r) { return r.norm() < kRoundingPx; });
  if (is_rounding) return false;
  NeighbourCorrelation neighbours;
  neighbours.add(pixels, residuals);
  // The correlation of noise has a standard deviation of 1 / sqrt(2 n), at most twice that where
  // pairs count double.
  const auto n = static_cast<double>(neighbours.num_points());
  return neighbours.correlation() > policy::kQuantile1e3 * 2 / std::sqrt(2 * n);
}

double largest_inlier_square(const NoiseLevel& noise, std::span<const double> fitted) {
  const double by_noise = kOutlierSquare * noise.sigma_px * noise.sigma_px;
  if (!is_self_estimated(noise) || fitted.size() < policy::kEnoughForMedian) return by_noise;
  return std::min(by_noise, std::max(largest_by_median(true, fitted),
                                     kOutlierSquare * kLeastPoseSigmaPx * kLeastPoseSigmaPx));
}

std::vector<std::size_t> complement(std::span<const std::size_t> chosen, std::size_t n) {
  std::vector<std::size_t> result;
  std::size_t next = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (next < chosen.size() && chosen[next] == i)
      ++next;
    else
      result.push_back(i);
  }
  return result;
}

}  // namespace tagcal::internal
