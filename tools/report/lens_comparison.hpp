#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal::tools {

inline constexpr double kLeastPx = 1e-6;  // numeric: a smaller difference is shown as 0

// One comparison of two lenses: the difference, and what the covariances of both predict.
struct Comparison {
  LensDifference difference;
  std::optional<DifferenceTest> test;
};

// Samples in the regions of the corners of both calibrations; the whole image if neither file has
// one.
std::vector<Eigen::Vector2d> common_region(const CalibrationFile& a, const CalibrationFile& b);

// The comparison with the largest difference in standard deviations; null if none has a test.
const Comparison* worst_of(std::span<const Comparison> comparisons);

// The verdict of a check (change_verdict) by the comparison that differs most, and a sentence. No
// verdict and no word if neither file has a covariance.
struct ComparisonVerdict {
  std::optional<CheckVerdict> verdict;
  std::string word;
  std::string sentence;
  double smallest_px = 0;  // the change that would have been seen, of all comparisons
};
ComparisonVerdict verdict_of(std::span<const Comparison> comparisons, double limit_px = 1);
std::string verdict_text(const ComparisonVerdict& verdict);  // lines for the terminal

// Compares two calibrations at each distance, which messages name. Throws Error if they have too
// little in common.
std::vector<Comparison> compare(const std::string& name_a, const UncertainCamera& a,
                                const std::string& name_b, const UncertainCamera& b,
                                std::span<const Eigen::Vector2d> samples,
                                std::span<const double> distances_m);

// The same of files.
std::vector<Comparison> compare(const std::string& file_a, const std::string& file_b,
                                std::span<const Eigen::Vector2d> samples,
                                std::span<const double> distances_m);

}  // namespace tagcal::tools
