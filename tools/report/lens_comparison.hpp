#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal::tools {

// Beyond this the calibrations contradict one another: 1 in 700 by chance.
inline constexpr double kMostSigmas = 3;
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

// Whether the calibrations agree as well as their covariances say: a word and a sentence.
struct ComparisonVerdict {
  enum class Kind { unknown, consistent, different } kind = Kind::unknown;
  std::string word;  // "" if it is not known
  std::string sentence;
};
ComparisonVerdict verdict_of(std::span<const Comparison> comparisons);

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
