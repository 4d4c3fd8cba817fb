#include "tagcal/scene/raster/blur.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace tagcal::internal {

// The box of a pixel is a sum of `scale` boxes of cells. The Gaussian is sampled, because its
// spectrum ends far below the frequency of the cells.
Blur::Blur(double blur_px, int scale) : scale_(scale) {
  const double sigma = blur_px * scale;
  const int reach = static_cast<int>(std::ceil(5 * sigma));
  std::vector<double> weights(static_cast<std::size_t>(2 * reach + scale), 0.0);
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    const double g = std::exp(-0.5 * i * i / (sigma * sigma));
    for (int j = 0; j < scale; ++j) weights[static_cast<std::size_t>(i + reach + j)] += g;
    sum += scale * g;
  }
  first_ = -reach;
  for (const double w : weights) weights_.push_back(static_cast<float>(w / sum));
}

void Blur::filter_row(const float* cells, int num_pixels, float* pixels) {
  const int num_cells = num_pixels * scale_;
  const int before = -first_;
  const auto after = static_cast<int>(weights_.size());
  padded_.resize(static_cast<std::size_t>(before + num_cells + after));
  std::fill_n(padded_.begin(), before, cells[0]);
  std::copy_n(cells, num_cells, padded_.begin() + before);
  std::fill_n(padded_.begin() + before + num_cells, after, cells[num_cells - 1]);
  const Eigen::Map<const Eigen::VectorXf> weights(weights_.data(), after);
  const Eigen::Map<const Eigen::VectorXf> row(padded_.data(), before + num_cells + after);
  for (int x = 0; x < num_pixels; ++x)
    pixels[x] = weights.dot(row.segment(static_cast<Eigen::Index>(x) * scale_, after));
}

ImageF Blur::filter_columns(const ImageF& rows) const {
  ImageF result({rows.width(), rows.height() / scale_}, 0.0f);
  for (int y = 0; y < result.height(); ++y) {
    float* out = result.row(y);
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      const int r = std::clamp(y * scale_ + first_ + static_cast<int>(i), 0, rows.height() - 1);
      const float* in = rows.row(r);
      for (int x = 0; x < rows.width(); ++x) out[x] += weights_[i] * in[x];
    }
  }
  return result;
}

}  // namespace tagcal::internal
