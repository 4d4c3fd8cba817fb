#include "tagcal/detect/tag_fit/straight_view.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tagcal/detect/tag_fit/tag_kernels.hpp"
#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSpacing = 8;       // px between the places that are computed exactly
constexpr double kDeltaPx = 0.5;  // numeric: of differences

// Weights of the values at -1, 0, 1 and 2 in the cubic through them, at 0 <= t < 1.
std::array<double, 4> cubic_weights(double t) {
  return {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
          (t + 1) * t * (t - 1) / 6};
}

using Row = std::vector<Vector2d>;

Row blended(const std::array<const Row*, 4>& rows, const std::array<double, 4>& weights) {
  Row result(rows[0]->size(), Vector2d::Zero());
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += weights[k] * (*rows[k])[i];
  return result;
}

}  // namespace

std::optional<StraightView> StraightView::about(const Lens& lens, const Vector2d& middle,
                                                double scale) {
  StraightView view;
  view.lens_ = lens;
  const auto ray = ray_in_camera(lens, middle);
  if (!ray) return std::nullopt;
  view.view_from_camera_ = rotation_between(ray->direction, Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Matrix2d tangent_from_pixel;
  for (int k = 0; k < 2; ++k) {
    const Vector2d delta = kDeltaPx * Vector2d::Unit(k);
    const auto more = view.tangent(middle + delta), less = view.tangent(middle - delta);
    if (!more || !less) return std::nullopt;
    tangent_from_pixel.col(k) = (*more - *less) / (2 * kDeltaPx);
  }
  if (!(std::abs(tangent_from_pixel.determinant()) > 0)) return std::nullopt;
  view.tangent_from_place_ = scale * tangent_from_pixel;
  return view;
}

std::optional<Vector2d> StraightView::tangent(const Vector2d& pixel) const {
  const auto ray = ray_in_camera(lens_, pixel);
  if (!ray) return std::nullopt;
  const Vector3d x = view_from_camera_ * ray->direction;
  if (!(x.z() > 0)) return std::nullopt;
  return x.hnormalized();
}

std::optional<Vector2d> StraightView::place(const Vector2d& pixel) const {
  const auto at = tangent(pixel);
  if (!at) return std::nullopt;
  return tangent_from_place_.inverse() * *at;
}

std::optional<Vector2d> StraightView::pixel(const Vector2d& place) const {
  const Vector3d x = Vector2d(tangent_from_place_ * place).homogeneous();
  return project(lens_, view_from_camera_.transpose() * x);
}

std::optional<Eigen::Matrix2d> StraightView::pixel_by_place(const Vector2d& place) const {
  constexpr double kDelta = 1e-4;  // numeric: of differences
  Eigen::Matrix2d result;
  for (int k = 0; k < 2; ++k) {
    const Vector2d delta = kDelta * Vector2d::Unit(k);
    const auto more = pixel(place + delta), less = pixel(place - delta);
    if (!more || !less) return std::nullopt;
    result.col(k) = (*more - *less) / (2 * kDelta);
  }
  return result;
}

StraightPlaces::StraightPlaces(const StraightView& view, const Eigen::Vector2i& first,
                               const ImageSize& size, double scale)
    : width_(size.width) {
  place(view, first, size);
  stretch(size, scale);
}

RowPlaces StraightPlaces::row(int row) const {
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row) * width_;
  return {x_.data() + at,  y_.data() + at,  xx_.data() + at,
          xy_.data() + at, yy_.data() + at, stretch_};
}

// Computes the stretch from differences of neighbouring places.
void StraightPlaces::stretch(const ImageSize& size, double scale) {
  for (std::vector<float>* values : {&xx_, &xy_, &yy_}) values->resize(x_.size());
  float largest = 1;
  for (int r = 0; r < size.height; ++r) {
    const int above = std::max(0, r - 1), below = std::min(size.height - 1, r + 1);
    const float per_row =
        static_cast<float>(scale) / static_cast<float>(std::max(1, below - above));
    for (int c = 0; c < width_; ++c) {
      const int before = std::max(0, c - 1), after = std::min(width_ - 1, c + 1);
      const float per_column =
          static_cast<float>(scale) / static_cast<float>(std::max(1, after - before));
      const auto index = [&](int row, int column) {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(column);
      };
      const auto across = [&](const std::vector<float>& v) {
        return per_column * (v[index(r, after)] - v[index(r, before)]);
      };
      const auto down = [&](const std::vector<float>& v) {
        return per_row * (v[index(below, c)] - v[index(above, c)]);
      };
      const float x_c = across(x_), x_r = down(x_), y_c = across(y_), y_r = down(y_);
      const std::size_t k = index(r, c);
      xx_[k] = x_c * x_c + x_r * x_r;
      xy_[k] = x_c * y_c + x_r * y_r;
      yy_[k] = y_c * y_c + y_r * y_r;
      // False for NaN, where there is no place.
      const float bound = std::max(xx_[k], yy_[k]) + std::abs(xy_[k]);
      if (bound > largest) largest = bound;
    }
  }
  stretch_ = std::sqrt(static_cast<double>(largest));
}

void StraightPlaces::place(const StraightView& view, const Eigen::Vector2i& first,
                           const ImageSize& size) {
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  const std::size_t with_room = pixels + kTagPack;  // rows are read by whole packs
  x_.reserve(with_room);
  y_.reserve(with_room);
  const Vector2d nowhere = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Row> nodes(static_cast<std::size_t>((size.height - 1) / kSpacing + 4));
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const double at_y = first.y() + kSpacing * (static_cast<double>(j) - 1);
    for (int i = -1; i < (size.width - 1) / kSpacing + 3; ++i)
      nodes[j].push_back(view.place({first.x() + kSpacing * i, at_y}).value_or(nowhere));
  }
  std::array<std::array<double, 4>, kSpacing> weights;
  for (std::size_t k = 0; k < kSpacing; ++k)
    weights[k] = cubic_weights(static_cast<double>(k) / kSpacing);
  for (int r = 0; r < size.height; ++r) {
    const auto j = static_cast<std::size_t>(r / kSpacing);
    const Row row = blended({&nodes[j], &nodes[j + 1], &nodes[j + 2], &nodes[j + 3]},
                            weights[static_cast<std::size_t>(r % kSpacing)]);
    for (int c = 0; c < width_; ++c) {
      const auto i = static_cast<std::size_t>(c / kSpacing);
      const std::array<double, 4>& w = weights[static_cast<std::size_t>(c % kSpacing)];
      const Vector2d place =
          w[0] * row[i] + w[1] * row[i + 1] + w[2] * row[i + 2] + w[3] * row[i + 3];
      x_.push_back(static_cast<float>(place.x()));
      y_.push_back(static_cast<float>(place.y()));
    }
  }
  x_.resize(with_room);
  y_.resize(with_room);
}

}  // namespace tagcal::internal
