#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/tag_lens.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"
#include "tagcal/detect/tag_fit/tag_region.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect: the least squares behind refine_tag().
namespace tagcal::internal {

using TagInformation = Eigen::Matrix<double, tag_parameter::kCount, tag_parameter::kCount>;
using TagProducts = Eigen::Matrix<double, kTagColumns, kTagColumns, Eigen::RowMajor>;
using TagCornerJacobian = Eigen::Matrix<double, 8, tag_parameter::kCount>;

// Variance of a pixel's square, px^2, and of rounding, levels^2.
constexpr double kBoxVariance = 1.0 / 12;

// The pixels about a tag.
struct TagPatch {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  std::vector<float> levels;  // row by row, and room for a pack

  const float* row(int y) const { return levels.data() + static_cast<std::ptrdiff_t>(y) * width; }
  float at(int x, int y) const { return row(y)[x]; }
};

// Pixels [begin, end) of a row.
struct PixelSpan {
  int begin = 0;
  int end = 0;
};

// The fit of one region of a tag.
class TagFitter {
 public:
  // The region and the options must outlive it.
  TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options);

  // Copies the pixels that the pattern reaches; false if the start is no view of a tag.
  template <typename T>
  bool cut(const ImageView<T>& image);
  // If the region is about one corner, the others and their covariance are zero.
  TagFit fit();
  // True if a lens bends the whole tag beyond third order. If few rows showed that already, fit()
  // has ended there, and its corners are only good as a start.
  bool is_for_parts() const { return is_for_parts_; }
  // Largest displacement of a corner by bends of third order, px.
  double third_order_px() const;

 private:
  bool look();
  std::optional<Eigen::AlignedBox2d> box() const;
  bool start_parameters(TagParameters& parameters) const;
  bool start_levels(TagParameters& parameters) const;
  void set_prior(const TagParameters& start);
  bool is_in_region(std::size_t corner) const;
  PixelSpan in_window(int row) const;
  PixelSpan in_picture(int row) const;
  void collect();
  void collect_row(int row);
  void add_span(TagBlock& block, PixelSpan span);
  void add_block(TagBlock& block);
  void add_flat(bool white);
  // Bring the parameters into the basin of the full iteration. False if a step is not finite.
  bool fit_windows();
  bool fit_few_rows();
  TagFit iterate();
  bool is_like_window() const;
  bool step();
  void widen_prior_of_bends();
  bool is_bent_beyond_whole() const;
  // The homography maps the tag to straightened places: pixels without the known lens.
  std::optional<Eigen::Vector2d> straight_place(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& straight_place) const;
  Eigen::Vector2d straight_corner(std::size_t i) const;
  Eigen::Vector2d corner(std::size_t i) const;
  TagCornerJacobian corner_jacobian() const;
  TagFit result() const;

  const TagRegion& region_;
  const TagFitOptions& options_;
  const TagCorners start_;
  double scale_;
  Eigen::Vector2d middle_;
  TagModel model_;
  std::optional<StraightView> view_;  // only if the lens is known
  std::optional<StraightPlaces> places_;
  Eigen::Matrix3d image_from_tag_;
  TagPatch patch_;
  ImageSize size_;  // of the picture

  // At the present parameters: blocks of pixels that depend on the geometry, by one line of each
  // direction and by several, and sums over all.
  std::array<TagBlock, 2> blocks_{};
  TagProducts products_;
  TagInformation information_;
  TagParameters gradient_;
  TagParameters prior_ = TagParameters::Zero();  // weights
  TagParameters prior_mean_ = TagParameters::Zero();
  double squares_ = 0;
  double variance_ = 1;
  std::array<TagFlatSums, 2> flat_;  // black, white
  std::vector<PixelSpan> spans_;     // of known pixels, row by row
  bool are_spans_fixed_ = false;
  double spans_spread_ = 0;  // the spread for which the spans were selected
  double window_px_ = 0;     // half side of the window about the region's corner; 0: the region
  TagParameters in_window_;  // fitted in the largest window
  double window_variance_ = 1;
  int row_step_ = 1;
  int num_bends_ = tag_parameter::kNumBends;  // free ones
  bool is_strongly_bent_ = false;
  int num_pixels_ = 0;
  double move_px_ = 0;        // largest move of a corner's coordinate in the last step
  double corner_size_ = 1e9;  // last step of the region's corner: squared, in its sds
  double left_over_ = 0;      // expected size of the next step: squared, in sds
  bool is_for_parts_ = false;
  int iterations_ = 0;
};

}  // namespace tagcal::internal
