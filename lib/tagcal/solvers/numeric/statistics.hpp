#pragma once

#include <span>
#include <vector>

namespace tagcal::internal {

// Returns log |gamma(x)|. Unlike std::lgamma it writes no global variable: threads may call it.
double log_gamma(double x);

// Upper median of one value or more.
double median(std::vector<double> values);

// Robust variance of a coordinate from the squared (whitened) lengths of one or more residuals, of
// which fewer than half may be outliers: their median is 2 ln 2 variances.
double robust_variance(std::span<const double> squares);

// Value that a chi-square of k degrees of freedom exceeds with the probability that a standard
// normal variable exceeds `normal_quantile` (Wilson & Hilferty 1931).
double chi_square_quantile(double k, double normal_quantile);

// Normal score of a ratio of two independent estimates of one variance, of a and b degrees of
// freedom: the quantile that is exceeded with the same probability (Paulson 1942).
double variance_ratio_score(double ratio, double a, double b);

// Non-centrality with which a chi-square of k degrees of freedom exceeds the value of
// `normal_quantile` (chi_square_quantile) with the probability that a standard normal variable is
// below `power_quantile` (Abdel-Aty, Biometrika 41, 538 (1954): the cube root is nearly normal).
double noncentrality(double k, double normal_quantile, double power_quantile);

}  // namespace tagcal::internal
