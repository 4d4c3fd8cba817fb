#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <variant>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"
#include "tagcal/solvers/plane.hpp"

// The start of a fit: its pixels and its first parameters.
namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace tag_parameter;

constexpr double kFilterVariance = 1.0 / 2;  // px^2, of the binomial filter 1 2 1

void set_homography(const Matrix3d& image_from_tag, TagParameters& parameters) {
  Matrix3d tag_from_image = image_from_tag.inverse();
  tag_from_image /= tag_from_image(2, 2);
  parameters.segment<3>(kM1) = tag_from_image.row(0);
  parameters.segment<3>(kM2) = tag_from_image.row(1);
  parameters.segment<2>(kM3) = tag_from_image.row(2).head<2>();
}

}  // namespace

std::optional<Vector2d> TagFitter::straight_place(const Vector2d& pixel) const {
  if (view_) return view_->place(pixel);
  return (pixel - region_.middle) / region_.scale;
}

std::optional<Vector2d> TagFitter::pixel(const Vector2d& straight_place) const {
  if (view_) return view_->pixel(straight_place);
  return region_.middle + region_.scale * straight_place;
}

bool TagFitter::look() {
  if (options_.camera && kind_of(options_.camera->lens).is_central) {
    view_ = StraightView::about(options_.camera->lens, region_.middle, region_.scale);
    if (!view_) return false;
  }
  std::array<Vector3d, 4> places;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto place = straight_place(start_[i]);
    if (!place) return false;
    places[i] = place->homogeneous();
  }
  const std::optional<Matrix3d> image_from_tag = homography(region_.corners_on_tag, places);
  if (image_from_tag) image_from_tag_ = *image_from_tag;
  return image_from_tag.has_value();
}

// A box around the pixels that the region may cover.
std::optional<Eigen::AlignedBox2d> TagFitter::box() const {
  constexpr int kSteps = 4;  // along each side, because the lens may bend it
  const auto& [columns, rows, cells] = region_.grid;
  Eigen::AlignedBox2d box;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const double u = columns.front() + i * (columns.back() - columns.front()) / kSteps;
      const double v = rows.front() + j * (rows.back() - rows.front()) / kSteps;
      const Vector3d p = image_from_tag_ * Vector3d(u, v, 1);
      if (!(p.z() > 0)) return std::nullopt;
      if (const auto at = pixel(p.hnormalized())) box.extend(*at);
    }
  }
  if (box.isEmpty()) return std::nullopt;
  return box;
}

template <typename T>
void TagFitter::copy_levels(const ImageView<T>& image) {
  constexpr float kFull = std::numeric_limits<T>::max();
  model_.set_range(0, kFull);
  if (options_.processing.sharpen.amount > 0) {
    unsharpened_.emplace(image, PixelBox{patch_.x0, patch_.y0, {patch_.width, patch_.height}},
                         options_.processing.sharpen);
    return copy_unsharpened();
  }
  for (int y = 0; y < patch_.height; ++y) {
    const T* row = image.row(patch_.y0 + y) + patch_.x0;
    patch_.levels.insert(patch_.levels.end(), row, row + patch_.width);
  }
}

template <typename T>
bool TagFitter::cut(const ImageView<T>& image) {
  if (!look()) return false;
  const auto covered = box();
  if (!covered) return false;
  size_ = image.size();
  const Vector2d last(image.width() - 1, image.height() - 1);
  const Vector2d low = covered->min().cwiseMax(0.0).cwiseMin(last);
  const Vector2d high = covered->max().cwiseMax(0.0).cwiseMin(last);
  patch_.x0 = static_cast<int>(std::floor(low.x()));
  patch_.y0 = static_cast<int>(std::floor(low.y()));
  patch_.width = static_cast<int>(std::ceil(high.x())) - patch_.x0 + 1;
  patch_.height = static_cast<int>(std::ceil(high.y())) - patch_.y0 + 1;
  copy_levels(image);
  patch_.levels.resize(patch_.levels.size() + kTagPack);
  if (view_)
    places_.emplace(*view_, Eigen::Vector2i(patch_.x0, patch_.y0),
                    ImageSize{patch_.width, patch_.height}, region_.scale);
  return true;
}

template bool TagFitter::cut(const ImageView8& image);
template bool TagFitter::cut(const ImageView16& image);

bool TagFitter::start_parameters(TagParameters& parameters) const {
  parameters.setZero();
  set_homography(image_from_tag_, parameters);
  parameters[kLogSpread] = std::log(policy::kUsualSpreadPx);
  return parameters.allFinite() && start_levels(parameters);
}

// Mean levels at the middles of black and of white cells.
bool TagFitter::start_levels(TagParameters& parameters) const {
  double sum[2] = {0, 0};
  int count[2] = {0, 0};
  const TagGrid& grid = region_.grid;
  const std::size_t n = grid.columns.size() - 1;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const std::size_t column = i % n, row = i / n;
    const double u = (grid.columns[column] + grid.columns[column + 1]) / 2;
    const double v = (grid.rows[row] + grid.rows[row + 1]) / 2;
    const auto place = pixel((image_from_tag_ * Vector3d(u, v, 1)).hnormalized());
    if (!place) continue;
    const double x = std::round(place->x()) - patch_.x0, y = std::round(place->y()) - patch_.y0;
    if (!(x >= 0 && y >= 0 && x < patch_.width && y < patch_.height)) continue;
    if (grid.cells[i] == TagPattern::unknown) continue;
    const int white = grid.cells[i] == TagPattern::white ? 1 : 0;
    sum[white] += patch_.at(static_cast<int>(x), static_cast<int>(y));
    ++count[white];
  }
  if (count[0] == 0 || count[1] == 0) return false;
  parameters[kBlack] = sum[0] / count[0];
  parameters[kGain] = sum[1] / count[1] - parameters[kBlack];
  return parameters[kGain] > 0;
}

bool TagFitter::start_fit() {
  TagParameters parameters;
  if (!start_parameters(parameters)) return false;
  set_prior(parameters);
  parameters.segment<2>(kShift) = prior_mean_.segment<2>(kShift);
  if (options_.rest && !begin_with(*options_.rest, parameters)) return false;
  model_.set(parameters);
  return true;
}

// The homography of the start maps to where the bends take the corners from.
bool TagFitter::begin_with(const TagFitRest& rest, TagParameters& parameters) const {
  parameters.tail<kNumRest>() = Eigen::Map<const TagRest>(rest.data());
  if (!has_bends_) {
    parameters.segment<kNumBends>(kBend).setZero();
    return true;
  }
  std::array<Vector3d, 4> places;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto place = straight_place(start_[i]);
    if (!place) return false;
    const BendBasis basis = bend_basis(place->x(), place->y());
    places[i] = (*place + basis * parameters.segment<kNumBends>(kBend)).homogeneous();
  }
  const std::optional<Matrix3d> image_from_tag = homography(region_.corners_on_tag, places);
  if (image_from_tag) set_homography(*image_from_tag, parameters);
  return image_from_tag && parameters.allFinite();
}

void TagFitter::copy_unsharpened() {
  patch_.beyond = unsharpened_->beyond();
  patch_.levels = unsharpened_->levels();
  patch_.levels.resize(patch_.levels.size() + kTagPack);
  model_.set_range(-patch_.beyond / 2, patch_.beyond / 2, patch_.beyond);
  is_selection_kept_ = false;
}

// Undoes the sharpening again, with the model's levels for those that are bounds.
void TagFitter::replace_bounds() {
  for (int y = 0; y < patch_.height; ++y)
    for (int x = 0; x < patch_.width; ++x)
      patch_.levels[static_cast<std::size_t>(y * patch_.width + x)] = patch_.at(x, y);
  patch_.beyond = 0;
  model_.set_range(-HUGE_VALF, HUGE_VALF);
  is_selection_kept_ = false;
  wants_flat_ = true;
  collect();
  wants_flat_ = false;
  std::vector<float> levels = patch_.levels;
  for (std::size_t i = 0; i + kTagPack < levels.size(); ++i)
    levels[i] -= border_residuals_[static_cast<Eigen::Index>(i)];
  unsharpened_->replace_bounds(levels);
  copy_unsharpened();
}

// Smooths the pixels by the binomial filter 1 2 1 in both directions, and the model with them.
void TagFitter::smooth() {
  const int width = patch_.width, height = patch_.height;
  const auto filtered = [&](auto&& level, int i, int count) {
    return (level(std::max(0, i - 1)) + 2 * level(i) + level(std::min(count - 1, i + 1))) / 4;
  };
  std::vector<float> across = patch_.levels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      across[static_cast<std::size_t>(y * width + x)] =
          filtered([&](int i) { return patch_.at(i, y); }, x, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      patch_.levels[static_cast<std::size_t>(y * width + x)] = filtered(
          [&](int i) { return across[static_cast<std::size_t>(i * width + x)]; }, y, height);
  TagParameters parameters = model_.parameters();
  parameters[kLogSpread] = std::log(std::hypot(model_.spread(), std::sqrt(kFilterVariance)));
  model_.set(parameters);
  is_smooth_ = true;
}

}  // namespace tagcal::internal
