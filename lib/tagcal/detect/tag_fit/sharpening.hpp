#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/scene/scene.hpp"

// Private to detect: the sharpening of a camera, undone.
namespace tagcal::internal {

using PixelLevels = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The levels of a part of a picture before its camera sharpened it. Sharpening makes every
// frequency larger, so that undoing it is stable, and independent noise is independent again. A
// level at an end of the picture's range is a bound, here, too.
class UnsharpenedPart {
 public:
  template <typename T>
  UnsharpenedPart(const ImageView<T>& image, const PixelBox& part, const Sharpen& sharpen);

  // Row by row. Bounds are moved by that much beyond the range (TagTable::beyond).
  std::vector<float> levels() const;
  float beyond() const { return 4 * full_; }  // numeric: farther than any overshoot
  bool has_bounds() const { return is_bound_.any(); }

  // Given levels, row by row, replace those of bounds where they are beyond them. What neighbours
  // have of a bound's overshoot is taken out of them again.
  void replace_bounds(const std::vector<float>& levels);

 private:
  void solve();
  PixelLevels bounds() const;

  PixelLevels seen_, levels_;  // with a margin about the part
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> is_bound_, is_held_;
  float full_;
  int top_, left_;
  ImageSize size_;
  Sharpen sharpen_;
};

// Mean over all frequencies of the logarithm of the gain. A density of levels before sharpening,
// divided by its exponential for each pixel, is one of the picture's levels.
double mean_log_gain(const Sharpen& sharpen);

}  // namespace tagcal::internal
