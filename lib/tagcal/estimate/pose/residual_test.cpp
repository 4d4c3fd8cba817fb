#include "tagcal/estimate/pose/residual_test.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tagcal::internal {
namespace {

// The RMS distance of the pixels from their centre.
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

}  // namespace

double robust_variance(std::span<const double> squares) {
  std::vector<double> sorted(squares.begin(), squares.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle / (2 * std::log(2.0));
}

double chi_square_quantile(double k, double normal_quantile) {
  const double root = 1 - 2 / (9 * k) + normal_quantile * std::sqrt(2 / (9 * k));
  return k * root * root * root;
}

double variance_ratio_score(double ratio, double a, double b) {
  const double root = std::cbrt(ratio), u = 2 / (9 * a), v = 2 / (9 * b);
  return ((1 - v) * root - (1 - u)) / std::sqrt(u + v * root * root);
}

Agreement agreement(const PoseProblem& problem, const NoiseLevel& noise,
                    std::span<const double> squares, int num_parameters) {
  constexpr double kOutlierSquare = kOutlierSigmas * kOutlierSigmas;
  const double cost = std::accumulate(squares.begin(), squares.end(), 0.0);
  const double largest = *std::max_element(squares.begin(), squares.end());
  const double freedom = 2 * static_cast<double>(squares.size()) - num_parameters;
  const double variance = noise.sigma_px * noise.sigma_px;
  const double usual = chi_square_quantile(freedom, kOutlierSigmas);
  const bool shown = !noise.known && !noise.assumed;  // by these very residuals, right or wrong
  if (!shown && largest <= kOutlierSquare * variance && cost <= usual * variance)
    return Agreement::full;
  // The median of n such squares strays by 1.44 / sqrt(n) of itself; what settled within 5 of its
  // own sigma must stay.
  const double n = static_cast<double>(squares.size());
  const double stray = shown ? 1 + 3 * 1.44 / std::sqrt(n) : 1;
  const bool alike =
      squares.size() < 6 || largest <= stray * kOutlierSquare * robust_variance(squares);
  const double rms = std::sqrt(cost / n);
  const bool small = noise.known ? cost <= kOutlierSquare * freedom * variance
                                 : rms <= 0.05 * size_px(problem.view().pixels);
  if (!alike || !small) return Agreement::partly;
  return shown ? Agreement::full : Agreement::noisy;
}

bool go_together(std::span<const Eigen::Vector2d> pixels,
                 std::span<const Eigen::Vector2d> residuals) {
  constexpr std::size_t kEnough = 12, kMany = 200;  // the search for neighbours is quadratic
  const std::size_t n = std::min(pixels.size(), kMany);
  if (n < kEnough) return false;
  double together = 0, square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t nearest = i == 0 ? 1 : 0;
    for (std::size_t j = 0; j < n; ++j)
      if (j != i &&
          (pixels[j] - pixels[i]).squaredNorm() < (pixels[nearest] - pixels[i]).squaredNorm())
        nearest = j;
    together += residuals[i].dot(residuals[nearest]);
    square += residuals[i].squaredNorm();
  }
  // Of noise the correlation is 0 with a standard deviation of 1 / sqrt(2 n), at most twice that
  // where pairs count double.
  return together > std::max(0.3, 6 / std::sqrt(2 * static_cast<double>(n))) * square;
}

std::vector<std::size_t> within(std::span<const double> squares, double sigma) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < squares.size(); ++i)
    if (squares[i] <= kOutlierSigmas * kOutlierSigmas * sigma * sigma) result.push_back(i);
  return result;
}

std::vector<std::size_t> others(std::span<const std::size_t> chosen, std::size_t n) {
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
