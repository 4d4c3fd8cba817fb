#include "tagcal/reproject/kernels/reproject_dispatch.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/internal/processor.hpp"

namespace tagcal::internal {

const ReprojectKernels& fastest_reproject_kernels() {
  static const bool is_avx2 = kAvx2ReprojectKernels.map_row[kPinhole] && runs_avx2();
  return is_avx2 ? kAvx2ReprojectKernels : kPortableReprojectKernels;
}

double lanczos_weight(double x) {
  constexpr double kLobes = kLanczosTaps / 2;
  if (x == 0) return 1;
  if (std::abs(x) >= kLobes) return 0;
  const double angle = std::numbers::pi * x;
  return std::sin(angle) * std::sin(angle / kLobes) / (angle * angle / kLobes);
}

const float* lanczos_profile() {
  static const std::vector<float> profile = [] {
    std::vector<float> values;
    for (int i = 0; i <= kProfileSteps * kLanczosTaps / 2 + 1; ++i)
      values.push_back(static_cast<float>(lanczos_weight(static_cast<double>(i) / kProfileSteps)));
    return values;
  }();
  return profile.data();
}

const float* lanczos_phases() {
  static const std::vector<float> phases = [] {
    std::vector<float> rows;
    for (int phase = 0; phase <= kPhases; ++phase) {
      double weights[kLanczosTaps], sum = 0;
      for (int k = 0; k < kLanczosTaps; ++k)
        sum += weights[k] = lanczos_weight(k - 3 - static_cast<double>(phase) / kPhases);
      for (const double weight : weights) rows.push_back(static_cast<float>(weight / sum));
    }
    return rows;
  }();
  return phases.data();
}

}  // namespace tagcal::internal
