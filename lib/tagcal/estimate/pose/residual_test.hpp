#pragma once

#include <vector>

#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// Further than this many standard deviations from the answer, a correspondence is wrong.
inline constexpr double kOutlierSigmas = 5;

// How the residuals of a least-squares fit go with the noise.
enum class Agreement {
  full,    // as they should
  noisy,   // larger than the noise that is stated or assumed, up to five times, but like noise
  partly,  // some are unlike the others, or all are too large for any noise
};

// `squares` are the squared whitened residuals, `num_parameters` what was fitted. Noise that the
// residuals show themselves is held against their median, and against the size of the target.
Agreement agreement(const PoseProblem& problem, const NoiseLevel& noise,
                    std::span<const double> squares, int num_parameters);

// Whether residuals go together from a point to its neighbour in the image, as noise does not: what
// a lens that bends or a target that is not flat leaves of a model without. `residuals` are not
// whitened; of fewer than 12 points nothing is said.
bool go_together(std::span<const Eigen::Vector2d> pixels,
                 std::span<const Eigen::Vector2d> residuals);

// The variance of a coordinate, whatever less than half of the residuals are, from the squared
// (whitened) lengths of one or more: their median is 2 ln 2 variances.
double robust_variance(std::span<const double> squares);

// The value that a chi-square of k degrees of freedom exceeds as rarely as a normal variable its
// quantile (Wilson & Hilferty 1931).
double chi_square_quantile(double k, double normal_quantile);

// The normal variable that is exceeded as rarely as a ratio of two independent estimates of one
// variance, of a and b degrees of freedom (Paulson 1942).
double variance_ratio_score(double ratio, double a, double b);

// Those within kOutlierSigmas, ascending.
std::vector<std::size_t> within(std::span<const double> squares, double sigma);

// All that are not in an ascending list of indices below n.
std::vector<std::size_t> others(std::span<const std::size_t> chosen, std::size_t n);

}  // namespace tagcal::internal
