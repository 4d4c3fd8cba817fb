#include "tagcal/scene/light/processing.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <vector>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using Block = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;

constexpr std::string_view kPatterns[] = {"RGGB", "BGGR", "GRBG", "GBRG"};
constexpr double kLuma[] = {0.299, 0.587, 0.114};  // ITU-R BT.601
// Bounds of what a scene may ask for: sharpening beyond them leaves two levels, and the loops over
// neighbours grow with the radius.
constexpr double kMostAmount = 10, kMostRadius_px = 10;

// Table K.1 of ITU-T T.81 quantizes luminance; it has quality 50.
constexpr int kQuantization[] = {16, 11, 10, 16, 24,  40,  51,  61,   //
                                 12, 12, 14, 19, 26,  58,  60,  55,   //
                                 14, 13, 16, 24, 40,  57,  69,  56,   //
                                 14, 17, 22, 29, 51,  87,  80,  62,   //
                                 18, 22, 37, 56, 68,  109, 103, 77,   //
                                 24, 35, 55, 64, 81,  104, 113, 92,   //
                                 49, 64, 78, 87, 103, 121, 120, 101,  //
                                 72, 92, 95, 98, 112, 100, 103, 99};

void check_range(std::string_view key, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw Error(fmt::format("{}: must be from {} to {}, got {}", key, low, high, value));
}

void check_positive(std::string_view key, double value, double most) {
  if (!(value > 0 && value <= most))
    throw Error(fmt::format("{}: must be above 0 and at most {}, got {}", key, most, value));
}

double nearest(const Levels& levels, int x, int y) {
  return levels(std::clamp(x, 0, levels.width() - 1), std::clamp(y, 0, levels.height() - 1));
}

// 0, 1, 2: red, green, blue.
int filter_colour(const Mosaic& mosaic, int x, int y) {
  const char letter = mosaic.pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
  return letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
}

// The mean of the pixels of a colour among a pixel and its eight neighbours; the pixel's own level
// if it has the colour, or if the image is too narrow for it.
double interpolated(const Mosaic& mosaic, const Levels& balanced, int colour, int x, int y) {
  if (filter_colour(mosaic, x, y) == colour) return balanced(x, y);
  double sum = 0;
  int count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, balanced.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, balanced.width() - 1); ++u) {
      if (filter_colour(mosaic, u, v) != colour) continue;
      sum += balanced(u, v);
      ++count;
    }
  }
  return count > 0 ? sum / count : balanced(x, y);
}

template <typename At>
Levels at_each_pixel(const ImageSize& size, const At& at) {
  Levels result(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) result(x, y) = at(x, y);
  return result;
}

// The picture of a mosaic, after the gamma.
Levels developed(const Mosaic& mosaic, double gamma, double white, const Levels& levels) {
  const auto after_gamma = [&](double level) {
    return white * encoded(std::min(level / white, 1.0), gamma);
  };
  if (!mosaic.demosaic)
    return at_each_pixel(levels.size(), [&](int x, int y) { return after_gamma(levels(x, y)); });
  const Levels balanced = at_each_pixel(
      levels.size(), [&](int x, int y) { return levels(x, y) / filter_gain(mosaic, x, y); });
  return at_each_pixel(levels.size(), [&](int x, int y) {
    double luma = 0;
    for (int colour = 0; colour < 3; ++colour)
      luma += kLuma[colour] * interpolated(mosaic, balanced, colour, x, y);
    return after_gamma(luma);
  });
}

// exp(-i^2 / (2 sigma^2)) for i = 0, 1, .. 3 sigma.
std::vector<double> half_gaussian(double sigma) {
  std::vector<double> weights;
  for (int i = 0; i <= static_cast<int>(std::ceil(3 * sigma)); ++i)
    weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  return weights;
}

Levels denoised(const Levels& levels, const Denoise& denoise, double white) {
  const std::vector<double> weights = half_gaussian(denoise.radius_px);
  const int reach = static_cast<int>(weights.size()) - 1;
  const double sigma = denoise.levels * white / 255;
  return at_each_pixel(levels.size(), [&](int x, int y) {
    double sum = 0, total = 0;
    for (int v = -reach; v <= reach; ++v) {
      for (int u = -reach; u <= reach; ++u) {
        const double level = nearest(levels, x + u, y + v);
        const double steps = (level - levels(x, y)) / sigma;
        const double weight = weights[static_cast<std::size_t>(std::abs(u))] *
                              weights[static_cast<std::size_t>(std::abs(v))] *
                              std::exp(-0.5 * steps * steps);
        sum += weight * level;
        total += weight;
      }
    }
    return sum / total;
  });
}

// Weighted means along (dx, dy).
Levels smoothed(const Levels& levels, const std::vector<double>& weights, int dx, int dy) {
  const double total = 2 * std::accumulate(weights.begin() + 1, weights.end(), weights[0] / 2);
  return at_each_pixel(levels.size(), [&](int x, int y) {
    double sum = weights[0] * levels(x, y);
    for (int i = 1; i < static_cast<int>(weights.size()); ++i)
      sum += weights[static_cast<std::size_t>(i)] *
             (nearest(levels, x - i * dx, y - i * dy) + nearest(levels, x + i * dx, y + i * dy));
    return sum / total;
  });
}

Levels sharpened(const Levels& levels, const Sharpen& sharpen, double white) {
  const std::vector<double> weights = half_gaussian(sharpen.radius_px);
  const Levels mean = smoothed(smoothed(levels, weights, 1, 0), weights, 0, 1);
  return at_each_pixel(levels.size(), [&](int x, int y) {
    return clipped(levels(x, y) + sharpen.amount * (levels(x, y) - mean(x, y)), white);
  });
}

// Row k has the cosines of frequency k (ITU-T T.81, A.3.3); the matrix is orthogonal.
Block cosine_transform() {
  return Block::NullaryExpr([](Eigen::Index k, Eigen::Index i) {
    const double scale = k == 0 ? std::sqrt(0.125) : 0.5;
    return scale * std::cos(static_cast<double>((2 * i + 1) * k) * std::numbers::pi / 16);
  });
}

// Table K.1 for a quality, as in libjpeg (jpeg_quality_scaling, jpeg_add_quant_table).
Block quantization(int quality) {
  const int percent = quality < 50 ? 5000 / quality : 200 - 2 * quality;
  return Block::NullaryExpr([percent](Eigen::Index v, Eigen::Index u) {
    return static_cast<double>(std::clamp((kQuantization[8 * v + u] * percent + 50) / 100, 1, 255));
  });
}

// Compression rounds the frequencies of each block of 8 x 8 bytes to multiples of its quantization.
Levels compressed(const Levels& bytes, int quality) {
  static const Block transform = cosine_transform();
  const Block steps = quantization(quality);
  Levels result(bytes.size());
  for (int y = 0; y < bytes.height(); y += 8) {
    for (int x = 0; x < bytes.width(); x += 8) {
      const Block block = Block::NullaryExpr([&](Eigen::Index v, Eigen::Index u) {
        const double level = nearest(bytes, x + static_cast<int>(u), y + static_cast<int>(v));
        return std::floor(clipped(level, 255) + 0.5) - 128;
      });
      const Block frequencies = transform * block * transform.transpose();
      const Block kept = (frequencies.array() / steps.array()).round() * steps.array();
      const Block back = transform.transpose() * kept * transform;
      for (int v = 0; v < std::min(8, bytes.height() - y); ++v)
        for (int u = 0; u < std::min(8, bytes.width() - x); ++u)
          result(x + u, y + v) = back(v, u) + 128;
    }
  }
  return result;
}

}  // namespace

void check_processing(const Sensor& sensor) {
  if (const auto& mosaic = sensor.mosaic) {
    if (std::ranges::find(kPatterns, mosaic->pattern) == std::end(kPatterns))
      throw Error(fmt::format("mosaic: pattern: must be RGGB, BGGR, GRBG or GBRG, got {}",
                              mosaic->pattern));
    for (const double gain : mosaic->gains) check_positive("mosaic: gains", gain, 100);
  }
  if (const auto& denoise = sensor.denoise) {
    check_positive("denoise: levels", denoise->levels, 255);
    check_positive("denoise: radius_px", denoise->radius_px, kMostRadius_px);
  }
  if (const auto& sharpen = sensor.sharpen) {
    check_range("sharpen: amount", sharpen->amount, 0, kMostAmount);
    check_positive("sharpen: radius_px", sharpen->radius_px, kMostRadius_px);
  }
  if (!sensor.jpeg) return;
  check_range("jpeg", *sensor.jpeg, 1, 100);
  if (sensor.bits == 16) throw Error("jpeg: has 8 bits only; leave out `bits: 16`");
}

double filter_gain(const Mosaic& mosaic, int x, int y) {
  return mosaic.gains[static_cast<std::size_t>(filter_colour(mosaic, x, y))];
}

void process(const Sensor& sensor, double white, Levels& levels) {
  if (sensor.mosaic) levels = developed(*sensor.mosaic, sensor.gamma, white, levels);
  if (sensor.denoise) levels = denoised(levels, *sensor.denoise, white);
  if (sensor.sharpen) levels = sharpened(levels, *sensor.sharpen, white);
  if (sensor.jpeg) levels = compressed(levels, *sensor.jpeg);
}

}  // namespace tagcal::internal
