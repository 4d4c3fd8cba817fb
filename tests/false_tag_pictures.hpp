#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tagcal/random.hpp"
#include "tagcal/scene/image.hpp"

// Pictures that hold no tag, for the tests of the detector.
namespace tagcal {

inline std::uint8_t as_level(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

class PictureWithoutTags {
 public:
  explicit PictureWithoutTags(std::uint64_t seed) : random_(seed), image_({640, 480}) {
    switch (seed % 5) {
      case 0:
        noise(1);
        break;
      case 1:
        noise(static_cast<int>(2 + random_.index(12)));
        break;
      case 2:
        letters();
        break;
      case 3:
        checkers();
        break;
      default:
        clutter();
    }
    for (int y = 0; y < image_.height(); ++y)
      for (int x = 0; x < image_.width(); ++x)
        image_(x, y) = as_level(image_(x, y) + 2 * random_.normal());
  }

  const Image8& image() const { return image_; }

 private:
  // Blocks of black and white: the payload of tags without order.
  void noise(int block) {
    const bool two_levels = random_.uniform() < 0.5;
    for (int y = 0; y < image_.height(); y += block) {
      for (int x = 0; x < image_.width(); x += block) {
        const auto level = static_cast<std::uint8_t>(random_.index(256));
        fill(x, y, block, two_levels ? (level < 128 ? 20 : 230) : level);
      }
    }
  }

  void fill(int x0, int y0, int size, std::uint8_t level) {
    for (int y = y0; y < std::min(y0 + size, image_.height()); ++y)
      for (int x = x0; x < std::min(x0 + size, image_.width()); ++x) image_(x, y) = level;
  }

  // Rows of glyphs of 5x7 cells, as text looks.
  void letters() {
    fill(0, 0, 640, 235);
    const int cell = static_cast<int>(1 + random_.index(5));
    for (int top = cell; top + 7 * cell < 480; top += 10 * cell) {
      for (int left = cell; left + 5 * cell < 640; left += 6 * cell) {
        const double share = random_.uniform() < 0.15 ? 0 : 0.5;
        for (int i = 0; i < 35; ++i)
          if (random_.uniform() < share) fill(left + i % 5 * cell, top + i / 5 * cell, cell, 25);
      }
    }
  }

  void checkers() {
    const double size = random_.uniform(6, 60), turn = random_.uniform(0, std::numbers::pi);
    const double slant = random_.uniform(0, 8e-4);
    for (int y = 0; y < image_.height(); ++y) {
      for (int x = 0; x < image_.width(); ++x) {
        const double scale = 1 / (1 + slant * x), px = x * scale, py = y * scale;
        const double u = px * std::cos(turn) + py * std::sin(turn);
        const double v = py * std::cos(turn) - px * std::sin(turn);
        const auto cell = static_cast<long>(std::floor(u / size) + std::floor(v / size));
        image_(x, y) = cell % 2 == 0 ? 30 : 220;
      }
    }
  }

  // Convex shapes over each other, many of them dark frames with something inside.
  void clutter() {
    fill(0, 0, 640, static_cast<std::uint8_t>(120 + random_.index(120)));
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector2d middle(random_.uniform(0, 640), random_.uniform(0, 480));
      const double size = random_.uniform(10, 70), turn = random_.uniform(0, 6.3);
      const Eigen::Vector2d a = size * Eigen::Vector2d(std::cos(turn), std::sin(turn));
      const Eigen::Vector2d b = random_.uniform(0.5, 1) * Eigen::Vector2d(-a.y(), a.x());
      quadrilateral(middle, 1.25 * a, 1.25 * b, 235);
      quadrilateral(middle, a, b, static_cast<std::uint8_t>(random_.index(60)));
      const auto bits = static_cast<int>(4 + random_.index(3));
      if (random_.uniform() < 0.6) payload(middle, a, b, bits);
    }
  }

  // A black frame one cell wide with random bits inside.
  void payload(const Eigen::Vector2d& middle, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
               int bits) {
    const double cells = bits + 2;
    for (int i = 0; i < bits * bits; ++i) {
      if (random_.uniform() < 0.5) continue;
      const double u = (2 * (i % bits) + 1 - bits) / cells, v = (2 * (i / bits) + 1 - bits) / cells;
      quadrilateral(middle + u * a + v * b, a / cells, b / cells, 235);
    }
  }

  void quadrilateral(const Eigen::Vector2d& middle, const Eigen::Vector2d& a,
                     const Eigen::Vector2d& b, std::uint8_t level) {
    const Eigen::Vector2d reach = a.cwiseAbs() + b.cwiseAbs();
    Eigen::Matrix2d axes;
    axes << a, b;
    const Eigen::Matrix2d inverse = axes.inverse();
    const auto first = [](double value) { return std::max(0, static_cast<int>(value)); };
    for (int y = first(middle.y() - reach.y());
         y < std::min(480, first(middle.y() + reach.y()) + 1); ++y) {
      for (int x = first(middle.x() - reach.x());
           x < std::min(640, first(middle.x() + reach.x()) + 1); ++x) {
        if ((inverse * (Eigen::Vector2d(x, y) - middle)).cwiseAbs().maxCoeff() < 1)
          image_(x, y) = level;
      }
    }
  }

  Random random_;
  Image8 image_;
};

inline Image8 picture_without_tags(std::uint64_t seed) { return PictureWithoutTags(seed).image(); }

}  // namespace tagcal
