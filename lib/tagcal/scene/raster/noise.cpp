#include "tagcal/scene/raster/noise.hpp"

namespace tagcal::internal {
namespace {

// Start of the tail and area of a layer, for 256 layers (Marsaglia & Tsang 2000).
constexpr double kTail = 3.6541528853610088;
constexpr double kArea = 4.92867323399e-3;

double density(double x) { return std::exp(-0.5 * x * x); }

}  // namespace

Ziggurat::Ziggurat() {
  x[0] = kArea / density(kTail);
  x[1] = kTail;
  for (std::size_t i = 2; i < kLayers; ++i)
    x[i] = std::sqrt(-2 * std::log(kArea / x[i - 1] + density(x[i - 1])));
  x[kLayers] = 0;
  for (std::size_t i = 0; i < kLayers; ++i) inside[i] = x[i + 1] / x[i];
}

const Ziggurat& NormalNoise::layers() {
  static const Ziggurat ziggurat;
  return ziggurat;
}

// A number of the tail (Marsaglia 1964).
double NormalNoise::beyond_layers(Random random) {
  while (true) {
    const double x = -std::log(1 - random.uniform()) / kTail;
    const double y = -std::log(1 - random.uniform());
    if (2 * y > x * x) return kTail + x;
  }
}

bool NormalNoise::is_below_density(std::size_t layer, double x, Random random) {
  const double low = density(layers().x[layer]), high = density(layers().x[layer + 1]);
  return low + random.uniform() * (high - low) < density(x);
}

}  // namespace tagcal::internal
