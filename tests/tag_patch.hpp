#pragma once

// Pictures of single tags, for the tests of the detector: drawn from the family's plain data
// through a homography by sub-samples, independently of the library's own renderer.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/random.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

struct PatchSpec {
  double side_px = 40;
  double max_tilt_rad = std::numbers::pi / 4;
  double blur_px = 0.8;
  double noise_levels = 2;
  bool corner_squares = false;  // and the neighbours of a Kalibr board
};

struct Patch {
  Image8 image;
  std::array<Eigen::Vector2d, 4> corners;
};

// Light from the plane of the tag; (u, v) in cells from the border's upper-left corner.
class TagSurface {
 public:
  TagSurface(const TagFamily& family, std::size_t id, bool corner_squares)
      : squares_(corner_squares),
        border_(family.width_at_border),
        total_(family.total_width),
        start_((family.total_width - family.width_at_border) / 2),
        white_(static_cast<std::size_t>(total_ * total_), 0) {
    const int first = start_ - (family.reversed_border ? 0 : 1);
    const int last = total_ - 1 - first;
    for (int i = first; i <= last; ++i) {
      for (const auto& [x, y] : {std::pair{i, first}, {i, last}, {first, i}, {last, i}}) {
        white_[static_cast<std::size_t>(y * total_ + x)] = 1;
      }
    }
    const std::size_t bits = family.bits.size();
    for (std::size_t i = 0; i < bits; ++i) {
      const int cell = (family.bits[i].y + start_) * total_ + family.bits[i].x + start_;
      white_[static_cast<std::size_t>(cell)] =
          (family.codes[id] >> (bits - 1 - i) & 1U) != 0 ? 1 : 0;
    }
  }

  bool is_white(double u, double v) const {
    if (squares_ && is_neighbour(u, v)) return false;
    const int x = static_cast<int>(std::floor(u)) + start_;
    const int y = static_cast<int>(std::floor(v)) + start_;
    if (x < 0 || y < 0 || x >= total_ || y >= total_) return true;
    return white_[static_cast<std::size_t>(y * total_ + x)] != 0;
  }

 private:
  bool is_neighbour(double u, double v) const {
    const double gap = 0.3 * border_;
    const auto zone = [&](double a) {  // 0 beside the tag, 1 in the gap, 2 beyond
      const double out = std::max(-a, a - border_);
      return out <= 0 ? 0 : out < gap ? 1 : 2;
    };
    return (zone(u) == 1 && zone(v) == 1) || (zone(u) == 2) != (zone(v) == 2);
  }

  bool squares_;
  int border_;
  int total_;
  int start_;
  std::vector<std::uint8_t> white_;
};

// The share of each sub-sample in a pixel: a box of one pixel, blurred.
inline std::vector<float> pixel_weights(int samples, double blur_px) {
  const int reach = samples / 2 + static_cast<int>(std::ceil(4 * blur_px * samples));
  const double s = std::numbers::sqrt2 * blur_px;
  std::vector<float> weights;
  double sum = 0;
  for (int i = -reach; i < reach; ++i) {
    const double at = (i + 0.5) / samples;
    const double share = std::erf((at + 0.5) / s) - std::erf((at - 0.5) / s);
    weights.push_back(static_cast<float>(share));
    sum += share;
  }
  for (float& weight : weights) weight = static_cast<float>(weight / sum);
  return weights;
}

// One row of pixels from one row of sub-samples `stride` apart.
inline void filter(const float* in, int stride, int count, int samples,
                   const std::vector<float>& weights, float* out) {
  const int reach = static_cast<int>(weights.size()) / 2;
  for (int pixel = 0; pixel < count; ++pixel) {
    float sum = 0;
    int at = pixel * samples + samples / 2 - reach;
    for (const float weight : weights) {
      sum += weight * in[std::clamp(at++, 0, count * samples - 1) * stride];
    }
    out[pixel * stride] = sum;
  }
}

inline Patch tag_patch(const TagFamily& family, std::size_t id, const PatchSpec& spec,
                       Random& random) {
  constexpr int kSamples = 6;
  constexpr double kFocal = 900;
  const int width = static_cast<int>(2.2 * spec.side_px) + 20;
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
  const double roll = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(random.uniform(0, spec.max_tilt_rad), axis).toRotationMatrix() *
      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Matrix3d camera = Eigen::Vector3d(kFocal, kFocal, 1).asDiagonal();
  camera.col(2).head<2>() = Eigen::Vector2d(width / 2.0 + random.uniform(-0.5, 0.5),
                                            width / 2.0 + random.uniform(-0.5, 0.5));
  // The tag's plane, one cell a unit, x right and y down on the upright tag.
  Eigen::Matrix3d homography = rotation / family.width_at_border;
  homography.col(2) =
      Eigen::Vector3d(0, 0, kFocal / spec.side_px) - 0.5 * (rotation.col(0) + rotation.col(1));
  homography = camera * homography;

  Patch patch;
  const double w = family.width_at_border;
  const double corners[4][2] = {{0, w}, {w, w}, {w, 0}, {0, 0}};
  for (std::size_t i = 0; i < 4; ++i) {
    patch.corners[i] =
        (homography * Eigen::Vector3d(corners[i][0], corners[i][1], 1)).hnormalized();
  }
  const TagSurface surface(family, id, spec.corner_squares);
  const Eigen::Matrix3d cells_from_pixels = homography.inverse();
  const int fine = width * kSamples;
  ImageF light({fine, fine});
  for (int y = 0; y < fine; ++y) {
    const Eigen::Vector3d start =
        cells_from_pixels * Eigen::Vector3d(0.5 / kSamples - 0.5, (y + 0.5) / kSamples - 0.5, 1);
    const double step[3] = {cells_from_pixels(0, 0) / kSamples, cells_from_pixels(1, 0) / kSamples,
                            cells_from_pixels(2, 0) / kSamples};
    float* out = light.row(y);
    for (int x = 0; x < fine; ++x) {
      const double scale = 1 / (start[2] + x * step[2]);
      const double u = (start[0] + x * step[0]) * scale;
      const double v = (start[1] + x * step[1]) * scale;
      out[x] = surface.is_white(u, v) ? 230.0F : 25.0F;
    }
  }
  const std::vector<float> weights = pixel_weights(kSamples, spec.blur_px);
  ImageF rows({width, fine});
  for (int y = 0; y < fine; ++y) filter(light.row(y), 1, width, kSamples, weights, rows.row(y));
  patch.image = Image8({width, width});
  ImageF pixels({width, width});
  for (int x = 0; x < width; ++x) {
    filter(rows.row(0) + x, width, width, kSamples, weights, pixels.row(0) + x);
    for (int y = 0; y < width; ++y) {
      const double level = pixels(x, y) + spec.noise_levels * random.normal();
      patch.image(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
    }
  }
  return patch;
}

}  // namespace tagcal
