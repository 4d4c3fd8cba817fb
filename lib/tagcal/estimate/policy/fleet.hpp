#pragma once

#include <cstddef>

// Every number that decides about populations of units (estimate/fleet.hpp), as policy.hpp.

namespace tagcal::internal::policy {

// Fewest units of a population: these, and these for each quantity. fleet_test counts the false
// outlying units at this size.
inline constexpr std::size_t kFewestUnits = 20;
inline constexpr std::size_t kFewestUnitsPerQuantity = 5;
// Most units that take part in the estimate; more are judged by it. The spread is then known to
// 1 / sqrt(2 * 20,000) = 0.5 %.
inline constexpr std::size_t kMostUsedUnits = 20'000;
// Share of units beyond p = 0.001 above which the population is not one normal distribution. Chosen
// by hand: fifty times what chance gives.
inline constexpr double kMixedShare = 0.05;
// Fewest trends with scatter whose median is an inflation of variances. Chosen by hand: the median
// of 10 ratios of 5 degrees of freedom is known to 25 %.
inline constexpr std::size_t kFewestTrends = 10;

// Residual degrees of freedom below which the scatter of a history is not known: F of 1 and 4 at
// p = 0.005 is 31, a change of 5.6 standard deviations; of fewer it is 7 or more.
inline constexpr int kFewestScatterFreedom = 4;

}  // namespace tagcal::internal::policy
