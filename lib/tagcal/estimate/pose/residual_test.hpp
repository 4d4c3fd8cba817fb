#pragma once

#include <vector>

#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {

// Agreement of the residuals of a least-squares fit with the noise.
enum class ResidualTest {
  consistent,
  noisy,  // larger than the stated or assumed noise, up to kOutlierSigmas times, without outliers
  inconsistent,  // with outliers, or too large for any noise
};

// Tests the squared whitened residuals `squares` of a fit of `num_parameters`. If the noise was
// estimated from these residuals, they are compared with their median and with the size of the
// target's image.
ResidualTest residual_test(const PoseProblem& problem, const NoiseLevel& noise,
                           std::span<const double> squares, int num_parameters);

// The correlation of the residuals (not whitened) of neighbouring points in the image, over views.
class NeighbourCorrelation {
 public:
  void add(std::span<const Eigen::Vector2d> pixels, std::span<const Eigen::Vector2d> residuals);
  double correlation() const { return square_ > 0 ? product_ / square_ : 0; }
  std::size_t num_points() const { return num_points_; }

 private:
  double product_ = 0, square_ = 0;
  std::size_t num_points_ = 0;
};

// True if the residuals (not whitened) of neighbouring points in the image are correlated: the
// error of a model whose lens or target is wrong, not noise. Few points show none: the bound of 19
// is a correlation of 1.
bool spatially_correlated(std::span<const Eigen::Vector2d> pixels,
                          std::span<const Eigen::Vector2d> residuals);

// The largest square of an inlier: kOutlierSigmas of the noise. Noise that was estimated from the
// squares of the `fitted` points is raised by outliers among them: then at most as many standard
// deviations by their median, which is what residual_test allows.
double largest_inlier_square(const NoiseLevel& noise, std::span<const double> fitted);

// Returns the indices below n that are not in an ascending list.
std::vector<std::size_t> complement(std::span<const std::size_t> chosen, std::size_t n);

}  // namespace tagcal::internal
