#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "tagcal/detect/tag_fit/sharpening.hpp"
#include "tagcal/detect/tag_fit/straight_view.hpp"
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
  float beyond = 0;           // as in TagTable

  const float* row(int y) const { return levels.data() + static_cast<std::ptrdiff_t>(y) * width; }
  // The level of a pixel; the bound where it is one.
  float at(int x, int y) const {
    const float level = row(y)[x];
    return level > beyond / 2 ? level - beyond : level < -beyond / 2 ? level + beyond : level;
  }
  // Number of residuals by pixels, and of zeros behind them.
  int room_for_residuals() const;
};

// Pixels [begin, end) of a row.
struct PixelSpan {
  int begin = 0;
  int end = 0;
};

// Sums over the pixels of a stage at some parameters.
struct TagSums {
  TagParameters at;
  TagInformation information;
  TagParameters gradient;
  double squares = 0;
  int num_pixels = 0;

  double mean_square() const { return squares / num_pixels; }
  // The variance of a pixel's level, at least that of rounding, if the squares become `left`.
  double variance(double left) const;
};

// A stage of the fit: the pixels that it uses, the parameters that are free, and its end.
struct FitStage {
  int max_steps = 0;
  bool is_rough = false;   // ends with a small step, and leads into the basin of the next stage
  double window_px = 0;    // half side of the window about the region's corner; 0: the region
  int row_step = 1;        // every how many-th row is used
  bool is_affine = false;  // perspective, shifts and bends are held
  double end_px = 0.25;    // numeric: of a rough stage: it ends with a smaller step of the corners
};

// The shift of a tag's borders (TagFit::shift_px).
struct BorderShift {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Vector2d weights = Eigen::Vector2d::Zero();  // 1/px^2, of each if the other is known
};

// Sums over pixels of one colour: products of 1, x, y, xx, xy, yy with each other and with the
// residual, and the squares of the residual.
struct FlatPixels {
  Eigen::Matrix<double, 6, 6> products;
  Eigen::Vector<double, 6> by_residual;
  double squares = 0;

  explicit FlatPixels(const TagFlatSums& sums = {});
  FlatPixels& operator+=(const FlatPixels& other);
  // The residuals after a change of the model by 1, x and y.
  void change_model(const Eigen::Vector3d& by);
};

// Terms of light beyond the model's (TagFitter::admit_light), and sums over all pixels of their
// products with each other and with the columns of a block; the last row is that of the residual.
struct LightSums {
  static constexpr int kTerms = 7;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  Terms light = Terms::Zero();  // that the residuals at borders are without
  Eigen::Matrix<double, kTagLightColumns, kTagColumns + kTagLightColumns, Eigen::RowMajor>
      products = decltype(products)::Zero();

  // The sum of the squares of all residuals without the light, from that with it.
  double squares_without_light(double squares) const {
    return squares + light.dot(own() * light - 2 * columns().row(kTagResidual).transpose());
  }
  Eigen::Matrix<double, kTerms, kTerms> own() const {
    return products.block<kTerms, kTerms>(0, kTagColumns).selfadjointView<Eigen::Lower>();
  }
  Eigen::Matrix<double, kTagColumns, kTerms> columns() const {
    return products.topLeftCorner<kTerms, kTagColumns>().transpose();
  }
};

// The model with each of some lines displaced, and sums over all pixels of the products of the
// derivatives by these displacements with all columns, those of light too, then with each other.
struct DisplacedLines {
  std::vector<TagModel> models;
  double by = 0;  // sides of the tag
  Eigen::MatrixXd products;
};

// How the squares of the residuals change if the lines within a tag are displaced, each by the same
// in both directions, and the tag's own parameters and the terms of light are adapted.
struct LineSums {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double squares = 0;     // of the residuals, with the lines where they are
  double num_pixels = 0;  // less those whose noise neighbours share

  // The decrease of the squares by displacements, in sides of the tag.
  double gain(const Eigen::VectorXd& by) const { return by.dot(2 * gradient - information * by); }
};

// A system of equations of the first parameters; the others are held.
class TagSystem {
 public:
  TagSystem(const TagInformation& system, int count)
      : inverse_(system.topLeftCorner(count, count)) {}

  template <typename Derived>
  auto solve(const Eigen::MatrixBase<Derived>& right) const {
    typename Derived::PlainObject result = right;
    const Eigen::Index count = inverse_.rows();
    result.topRows(count) = inverse_.solve(right.topRows(count));
    result.bottomRows(right.rows() - count).setZero();
    return result;
  }

 private:
  static constexpr int kMost = tag_parameter::kCount;
  Eigen::LDLT<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>> inverse_;
};

enum class StageEnd { reached, too_few_pixels, not_finite };

struct FitStep {
  TagParameters next;
  double variance = 1;       // of a pixel, as the linear model predicts it
  double move_px = 0;        // largest move of a corner's coordinate
  double left_over = 0;      // expected size of the step after it: squared, in sds
  double corner_size = 1e9;  // the region's only corner: squared, in its sds
};

// The fit of one region of a tag, by a list of stages.
class TagFitter {
 public:
  // The region, the options and the shift must outlive it. A known shift of the borders replaces
  // the prior in the options.
  TagFitter(const TagRegion& region, const TagCorners& start, const TagFitOptions& options,
            const BorderShift* known_shift = nullptr);

  // Copies the pixels that the pattern reaches; false if the start is no view of a tag.
  template <typename T>
  bool cut(const ImageView<T>& image);
  // If the region is about one corner, the others and their covariance are zero.
  TagFit fit();
  // The shift of the borders by a few rows of the region; fit() may follow. No value if their
  // iteration fails.
  std::optional<BorderShift> border_shift();
  // After a fit() of a whole tag that has converged.
  LineSums line_sums();
  // True if a lens bends the whole tag beyond third order. If few rows showed that already, fit()
  // has ended there, and its corners are only good as a start.
  bool is_for_parts() const { return is_for_parts_; }
  // Largest displacement of a corner by bends of third order, px.
  double third_order_px() const;

 private:
  template <typename T>
  void copy_levels(const ImageView<T>& image);
  void copy_unsharpened();
  void replace_bounds();
  bool look();
  std::optional<Eigen::AlignedBox2d> box() const;
  bool start_fit();
  bool start_parameters(TagParameters& parameters) const;
  bool start_levels(TagParameters& parameters) const;
  bool begin_with(const TagFitRest& rest, TagParameters& parameters) const;
  void set_prior(const TagParameters& start);
  bool is_in_region(std::size_t corner) const;

  // Computes the sums of the present stage: over its pixels as they were selected, if the selection
  // is kept.
  void collect();
  void select();
  void select_row(int row, std::array<TagFlatSums, 2>& flat);
  PixelSpan in_window(int row) const;
  PixelSpan in_picture(int row) const;
  void add_span(std::deque<TagBlock>& blocks, TagBlock*& block, int row, PixelSpan span);
  void add_block(TagBlock& block);
  void keep_residuals(const TagBlock& block);
  void add_flat_pixels();
  void add_flat(bool white);

  TagFit fit_by(const FitStage& stage);
  TagFit fit_last(const FitStage& stage);
  bool may_need_light() const;
  LightSums collect_light();
  double squares_without(const LightSums::Terms& light);
  void add_light(const TagBlock& block);
  void add_flat_light(bool white);
  void admit_light();
  DisplacedLines displaced_lines() const;
  void add_lines(TagBlock& block);
  double noise_factor() const;
  void smooth();
  std::vector<FitStage> rough_stages() const;
  StageEnd run(const FitStage& stage);
  void damp_if_worse(const std::optional<TagSums>& before, bool of_same_pixels);
  TagParameters prior_weights() const;
  double share_left(const TagParameters& change, double move_px) const;
  std::optional<FitStep> step() const;
  bool widen_prior_of_bends();
  bool is_bent_beyond_whole() const;
  // A fit of one corner whose result another fit completes.
  bool is_quick() const { return region_.corner && options_.lens_follows; }
  bool frees_bends() const { return has_bends_ && !stage_.is_affine; }

  // The homography maps the tag to straightened places: pixels without the known lens.
  std::optional<Eigen::Vector2d> straight_place(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& straight_place) const;
  Eigen::Vector2d straight_corner(std::size_t i) const;
  Eigen::Vector2d corner(std::size_t i) const;
  TagCornerJacobian corner_jacobian() const;
  // The inverse of the parameters' covariance by `times` the pixels of the last sums, and the
  // prior.
  TagSystem posterior(double times) const;
  // Systems of equations are those of the parameters that are not held.
  TagSystem solvable(const TagInformation& system) const {
    return TagSystem(system, frees_bends() ? tag_parameter::kCount : tag_parameter::kBend);
  }
  TagFit result(StageEnd end) const;
  TagFit corners_so_far() const;  // those of the start where the model has none

  const TagRegion& region_;
  const TagFitOptions& options_;
  const BorderShift* const known_shift_;
  const TagCorners start_;
  TagModel model_;
  std::optional<StraightView> view_;  // only if the lens is known
  std::optional<StraightPlaces> places_;
  Eigen::Matrix3d image_from_tag_;
  std::optional<UnsharpenedPart> unsharpened_;  // only if the picture is sharpened
  TagPatch patch_;
  ImageSize size_;                               // of the picture
  TagParameters prior_ = TagParameters::Zero();  // weights
  TagParameters prior_mean_ = TagParameters::Zero();
  bool has_bends_ = false;
  bool is_prior_widened_ = false;

  FitStage stage_;
  // The selected pixels: blocks of those that depend on the geometry, by one line of each direction
  // or by several, and of black and white ones at ends of the range; of each kind the last is open.
  // Sums over the other black and white ones, at the parameters at which they were selected.
  std::deque<TagBlock> blocks_;
  std::array<std::deque<TagBlock>, 2> ends_;
  std::array<TagBlock*, 4> open_{};
  std::array<FlatPixels, 2> selected_flat_;
  TagParameters selected_at_;
  bool is_selection_kept_ = false;
  TagDerivatives derivatives_;  // of a block
  TagProducts products_;
  std::array<FlatPixels, 2> flat_;           // at the present parameters
  std::optional<LightSums> light_;           // if wanted
  std::optional<DisplacedLines> displaced_;  // if wanted
  Eigen::VectorXf border_residuals_;  // by pixels of the patch; zero elsewhere and behind them
  double noise_factor_ = 1;
  TagSums sums_;
  double damping_ = 0;  // Levenberg and Marquardt's
  FitStep last_;
  int iterations_ = 0;
  bool is_for_parts_ = false;
  bool is_smooth_ = false;   // the pixels
  bool wants_flat_ = false;  // residuals of pixels of one colour, too
};

}  // namespace tagcal::internal
