#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tagcal/reproject/kernels/reproject_dispatch.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/footprints.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal::internal {

// The kernel of an interpolation, widened: its half-width and its value at a distance, both in
// units of its width.
struct TentKernel {
  static constexpr double kReach = 1;
  static double at(double x) { return std::max(0.0, 1 - std::abs(x)); }
};
struct LanczosKernel {
  static constexpr double kReach = kLanczosTaps / 2;
  static double at(double x) { return lanczos_weight(x); }
};

// Weighted means over footprints. Keeps its memory from pixel to pixel: one object per thread.
template <typename T, int kValues, typename Kernel>
class Averager {
 public:
  // `pixels`: rows of `stride` values.
  Averager(const T* pixels, std::ptrdiff_t stride, const ImageSize& size)
      : pixels_(pixels), stride_(stride), size_(size) {}

  // The mean about (x, y), to kValues values.
  void at(double x, double y, const Footprint& footprint, double* values) {
    std::fill_n(values, kValues, 0.0);
    const double length = footprint.along.norm();
    const int half =
        length > 0
            ? static_cast<int>(std::ceil(length / (policy::kSampleDistance * footprint.width)))
            : 0;
    double sum = 0;
    for (int k = -half; k <= half; ++k) {
      const double place = static_cast<double>(k) / (half + 1), weight = 1 - std::abs(place);
      add(x + place * footprint.along.x(), y + place * footprint.along.y(), footprint.width, weight,
          values);
      sum += weight;
    }
    for (int k = 0; k < kValues; ++k) values[k] /= sum;
  }

 private:
  // The taps of one axis and their weights, which sum to 1. Taps beyond the border take the pixel
  // at the border.
  struct Taps {
    std::vector<int> places;
    std::vector<double> weights;

    void set(double centre, double width, int extent) {
      places.clear();
      weights.clear();
      const double reach = Kernel::kReach * width;
      const int first = static_cast<int>(std::floor(centre - reach)) + 1;
      const int last = static_cast<int>(std::ceil(centre + reach)) - 1;
      double sum = 0;
      for (int i = first; i <= last; ++i) {
        places.push_back(std::clamp(i, 0, extent - 1));
        weights.push_back(Kernel::at((i - centre) / width));
        sum += weights.back();
      }
      for (double& weight : weights) weight /= sum;
    }
  };

  void add(double x, double y, double width, double weight, double* values) {
    across_.set(x, width, size_.width);
    down_.set(y, width, size_.height);
    for (std::size_t j = 0; j < down_.places.size(); ++j) {
      const T* const row = pixels_ + down_.places[j] * stride_;
      double sums[kValues] = {};
      for (std::size_t i = 0; i < across_.places.size(); ++i)
        for (int k = 0; k < kValues; ++k)
          sums[k] += across_.weights[i] * row[across_.places[i] * kValues + k];
      for (int k = 0; k < kValues; ++k) values[k] += weight * down_.weights[j] * sums[k];
    }
  }

  const T* pixels_;
  std::ptrdiff_t stride_;
  ImageSize size_;
  Taps across_, down_;
};

}  // namespace tagcal::internal
