#include "tagcal/scene/raster/blur.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tagcal/scene/raster/coverage.hpp"

namespace tagcal::internal {
namespace {

constexpr double kReachSigmas = 5;  // numeric: the Gaussian is 4e-6 of its height there

}  // namespace

int blur_reach_px(double blur_px) {
  return blur_px > 0 ? static_cast<int>(std::ceil(kReachSigmas * blur_px)) + 1 : 0;
}

// The box of a pixel is a sum of `scale` boxes of cells. The Gaussian is sampled, because its
// spectrum ends far below the frequency of the cells.
Blur::Blur(double blur_px, int scale, float factor, ImageF& image)
    : image_(image),
      scale_(scale),
      reach_(static_cast<int>(std::ceil(kReachSigmas * blur_px * scale))) {
  const double sigma = blur_px * scale;
  const int count = 2 * reach_ + scale;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
  for (int i = -reach_; i <= reach_; ++i)
    weights.segment(i + reach_, scale).array() += std::exp(-0.5 * i * i / (sigma * sigma));
  weights /= weights.sum();
  tail_ = (count + scale - 1) / scale;
  for (int phase = 0; phase < scale; ++phase) {
    for (int pixel = tail_ - 1; pixel >= 0; --pixel) {
      const int cell = phase + pixel * scale;  // where the change is, counted from the first weight
      const bool within = cell > 0 && cell < count;
      tails_.push_back(within ? static_cast<float>(weights.tail(count - cell).sum()) : 0);
    }
  }
  row_.resize(static_cast<std::size_t>(image.width() + 2 * tail_));
  window_.resize(image.width(), 2 * count);
  weights_ = factor * weights.cast<float>();
}

void Blur::add_row(const float* cells, std::span<const std::uint64_t> passed) {
  filter_row(cells, passed);
  for (int copies = num_rows_ == 0 ? reach_ + 1 : 1; copies > 0; --copies) repeat_row();
}

void Blur::finish() {
  for (int i = 0; i < weights_.size(); ++i) repeat_row();
}

// A pixel is the level of the cell with its first weight, plus every later change of level times
// the weights beyond it: exact where the level is uniform, and work only where it is not.
void Blur::filter_row(const float* cells, std::span<const std::uint64_t> passed) {
  constexpr int kBlock = CoverageBand::kBlock;
  const int num_cells = image_.width() * scale_;
  float* first = row_.data() + tail_;  // of the pixels whose level is not set
  for (std::size_t word = 0; word < passed.size(); ++word) {
    for (std::uint64_t blocks = passed[word]; blocks != 0; blocks &= blocks - 1) {
      const int begin = kBlock * (64 * static_cast<int>(word) + std::countr_zero(blocks));
      for (int c = std::max(1, begin); c < std::min(begin + kBlock, num_cells); ++c)
        if (cells[c] != cells[c - 1]) first = add_step(c, cells[c - 1], cells[c], first);
    }
  }
  std::fill(first, std::max(first, row_.data() + tail_ + image_.width()), cells[num_cells - 1]);
}

// Sets the pixels from `first` on whose first weight is of a cell before this one, adds the change
// of level, and returns the pixel after them.
float* Blur::add_step(int cell, float before, float level, float* first) {
  const unsigned place = static_cast<unsigned>(cell + reach_),
                 cells = static_cast<unsigned>(scale_);
  const std::ptrdiff_t pixel = place / cells, phase = place % cells;
  float* const affected = row_.data() + pixel + 1;
  float* const end = affected + tail_ - (phase == 0 ? 1 : 0);
  if (first < end) std::fill(first, end, before);
  const float* tails = tails_.data() + phase * tail_;
  for (int i = 0; i < tail_; ++i) affected[i] += (level - before) * tails[i];
  return end;
}

// Adds the filtered row to the window and computes the row of pixels that this completes.
void Blur::repeat_row() {
  const Eigen::Index count = weights_.size(), slot = num_rows_++ % count, width = image_.width();
  const Eigen::Map<const Eigen::VectorXf> row(row_.data() + tail_, width);
  window_.col(slot) = window_.col(slot + count) = row;
  const Eigen::Index y = (num_rows_ - count) / scale_;
  if (num_rows_ < count || (num_rows_ - count) % scale_ != 0 || y >= image_.height()) return;
  Eigen::Map<Eigen::VectorXf>(image_.row(static_cast<int>(y)), width).noalias() =
      window_.middleCols(num_rows_ % count, count) * weights_;
}

}  // namespace tagcal::internal
