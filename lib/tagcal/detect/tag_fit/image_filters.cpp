#include "tagcal/detect/tag_fit/image_filters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

// Gains that bring the four phases of a raw mosaic to one level (even and odd columns of even rows,
// then of odd rows), all 1 or more. No value for other pictures.
using MosaicGains = std::array<double, 4>;

std::optional<MosaicGains> mosaic_gains(const ImageView8& image) {
  // Blocks of 2x2 pixels from the brighter half, which shows paper, without those of which a part
  // is saturated. Borders and texture have no phase, so medians of the shares are those of filters.
  struct Block {
    float sum;
    std::array<float, 4> share;
  };
  constexpr double kBlocks = 4000;  // numeric: a sample of the blocks
  constexpr float kDarkest = 64;    // numeric: a step of one level is 6 % of a darker pixel
  const double pixels = static_cast<double>(image.width()) * image.height();
  const int step = 2 * std::max(1, static_cast<int>(std::sqrt(pixels / kBlocks) / 2));  // px
  std::vector<Block> blocks;
  for (int y = 0; y + 1 < image.height(); y += step) {
    for (int x = 0; x + 1 < image.width(); x += step) {
      const std::array<std::uint8_t, 4> p = {image(x, y), image(x + 1, y), image(x, y + 1),
                                             image(x + 1, y + 1)};
      const auto [least, most] = std::ranges::minmax(p);
      if (least < 255 && most == 255) continue;
      const auto sum = static_cast<float>(p[0] + p[1] + p[2] + p[3]);
      if (sum < kDarkest) continue;
      blocks.push_back({sum, {p[0] / sum, p[1] / sum, p[2] / sum, p[3] / sum}});
    }
  }
  if (blocks.size() < 2) return std::nullopt;
  const auto half = static_cast<std::ptrdiff_t>(blocks.size() / 2);
  std::ranges::nth_element(blocks, blocks.begin() + half, std::ranges::greater(), &Block::sum);
  std::array<double, 4> shares{}, errors{};
  for (std::size_t k = 0; k < 4; ++k) {
    std::vector<double> all;
    for (auto block = blocks.begin(); block != blocks.begin() + half; ++block)
      all.push_back(block->share[k]);
    shares[k] = median(all);
    for (double& share : all) share = std::abs(share - shares[k]);
    constexpr double kMedianError = 1.858;  // numeric: of normal values, of their median deviation
    errors[k] = kMedianError * median(std::move(all)) / std::sqrt(half);
  }
  const auto least = std::ranges::min_element(shares), most = std::ranges::max_element(shares);
  // In small pictures the structure itself can differ between the phases.
  const auto bound = [&](auto share) {
    return policy::kMosaicSigmas * errors[static_cast<std::size_t>(share - shares.begin())];
  };
  if (!(*least > 0) || *most - bound(most) < policy::kMosaicRatio * (*least + bound(least)))
    return std::nullopt;
  MosaicGains gains;
  for (std::size_t k = 0; k < 4; ++k) gains[k] = *most / shares[k];
  return gains;
}

Image8 with_gains(const ImageView8& image, const MosaicGains& gains) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double level = gains[static_cast<std::size_t>(2 * (y % 2) + x % 2)] * image(x, y);
      result(x, y) = static_cast<std::uint8_t>(std::lround(std::min(level, 255.0)));
    }
  }
  return result;
}

// True if hardly any pixel of a border has a level between those of its two sides.
bool has_two_levels(const ImageView8& image) {
  constexpr int kRowStep = 4;  // numeric: a sample of the rows
  int least = 255, most = 0;
  for (int y = 0; y < image.height(); y += kRowStep) {
    const auto [low, high] = std::minmax_element(image.row(y), image.row(y) + image.width());
    least = std::min<int>(least, *low);
    most = std::max<int>(most, *high);
  }
  // The outer eighths of the range are the two levels.
  const int low = least + (most - least) / 8, high = most - (most - least) / 8;
  int num_between = 0, num_steps = 0;
  for (int y = 0; y < image.height(); y += kRowStep) {
    const std::uint8_t* row = image.row(y);
    for (int x = 1; x < image.width(); ++x) {
      const auto [below, above] = std::minmax(row[x - 1], row[x]);
      num_between += row[x] > low && row[x] < high;
      num_steps += below <= low && above >= high;
    }
  }
  return most - least >= policy::kMinContrast &&
         num_between < policy::kMostBetweenLevels * num_steps;
}

// By the binomial filter 1 2 1 in both directions; no level is a bound, as of a clipped pixel.
Image8 smoothed(const ImageView8& image) {
  const int width = image.width(), height = image.height();
  Image8 result(image.size());
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* above = image.row(std::max(0, y - 1));
    const std::uint8_t* here = image.row(y);
    const std::uint8_t* below = image.row(std::min(height - 1, y + 1));
    const auto column = [&](int x) { return above[x] + 2 * here[x] + below[x]; };
    for (int x = 0; x < width; ++x) {
      const int sum =
          column(std::max(0, x - 1)) + 2 * column(x) + column(std::min(width - 1, x + 1));
      result(x, y) = static_cast<std::uint8_t>(std::clamp((sum + 8) / 16, 1, 254));
    }
  }
  return result;
}

}  // namespace

Image8 halved(const ImageView8& image) {
  const int width = image.width() / 2;  // outside of the image, so that compilers vectorise
  Image8 result({width, image.height() / 2});
  for (int y = 0; y < result.height(); ++y) {
    const std::uint8_t* above = image.row(2 * y);
    const std::uint8_t* below = image.row(2 * y + 1);
    std::uint8_t* out = result.row(y);
    for (int x = 0; x < width; ++x) {
      const int sum = above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1];
      out[x] = static_cast<std::uint8_t>((sum + 2) / 4);
    }
  }
  return result;
}

Image8 doubled(const ImageView8& image) {
  // New pixels lie a quarter to each side of the old ones.
  static constexpr int kWeights[4] = {-6, 58, 222, -18};  // of 256: 1.75, 0.75, 0.25 and 1.25 away
  const auto at = [](const auto& value, int i, int n, bool after) {
    int sum = 0;
    for (int k = 0; k < 4; ++k) {
      const int j = after ? i + 2 - k : i - 2 + k;
      sum += kWeights[k] * value(std::clamp(j, 0, n - 1));
    }
    return sum;
  };
  const int width = image.width(), height = image.height();
  std::vector<int> above(static_cast<std::size_t>(width));
  Image8 result({2 * width, 2 * height});
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < width; ++x)
      above[static_cast<std::size_t>(x)] =
          at([&](int row) { return int{image.row(row)[x]}; }, y / 2, height, y % 2 == 1);
    std::uint8_t* out = result.row(y);
    for (int x = 0; x < result.width(); ++x) {
      const int sum = at([&](int column) { return above[static_cast<std::size_t>(column)]; }, x / 2,
                         width, x % 2 == 1);
      out[x] = static_cast<std::uint8_t>(std::clamp((sum + (1 << 15)) >> 16, 0, 255));
    }
  }
  return result;
}

double noise_of(const ImageView8& image) {
  // A quarter of the second differences along a row lies below the noise's 62.5 % quantile times
  // sqrt(1 + 4 + 1); a histogram of half levels, because a difference d covers d - 1/2 to d + 1/2.
  constexpr int kRowStep = 4;                // numeric: a sample of the rows
  constexpr double kQuantile = 0.318639364;  // numeric: normal quantile at 0.625
  std::array<int, 2 * 255 + 1> count{};
  int total = 0;
  for (int y = 0; y < image.height(); y += kRowStep) {
    const std::uint8_t* row = image.row(y);
    for (int x = 1; x + 1 < image.width(); ++x, ++total)
      ++count[static_cast<std::size_t>(std::abs(row[x - 1] - 2 * row[x] + row[x + 1]))];
  }
  double below = 0;
  std::size_t d = 0;
  while (below + count[d] < total / 4.0) below += count[d++];
  const double share = (total / 4.0 - below) / std::max(1, count[d]);
  const double quantile = d == 0 ? share / 2 : static_cast<double>(d) - 1.0 / 2 + share;
  return quantile / (kQuantile * std::sqrt(6.0));
}

PictureToSearch::PictureToSearch(const ImageView8& image) : pixels(image) {
  if (const auto gains = mosaic_gains(image)) {
    gain = std::ranges::max(*gains);
    changed_ = with_gains(image, *gains);
  } else if (has_two_levels(image)) {
    changed_ = smoothed(image);
  } else {
    return;
  }
  pixels = changed_;
}

Image8 part_of(const ImageView8& image, const PixelBox& box) {
  Image8 result(box.size);
  for (int y = 0; y < box.size.height; ++y)
    std::copy_n(image.row(box.top + y) + box.left, box.size.width, result.row(y));
  return result;
}

}  // namespace tagcal::internal
