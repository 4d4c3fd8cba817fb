#include "tagcal/detect/tag_fit/straight_view.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tagcal/geometry/pose.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSpacing = 8;       // px between the places that are computed exactly
constexpr double kDeltaPx = 0.5;  // numeric: of differences

using Segment = Eigen::Array<float, 1, kSpacing>;

// Weights of the values at -1, 0, 1 and 2 in the cubic through them, at 0 <= t < 1 in equal steps.
std::array<Segment, 4> cubic_weights() {
  const Segment t = Segment::LinSpaced(0, kSpacing - 1) / kSpacing;
  return {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
          (t + 1) * t * (t - 1) / 6};
}

// Number of segments that cover some pixels.
int num_segments(int pixels) { return (pixels + kSpacing - 1) / kSpacing; }

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
  return {&x_(row + 1, 1), &y_(row + 1, 1), &xx_(row, 0), &xy_(row, 0), &yy_(row, 0), stretch_};
}

// Computes the places of the pixels, and of those one farther to each side.
void StraightPlaces::place(const StraightView& view, const Eigen::Vector2i& first,
                           const ImageSize& size) {
  const int rows = size.height + 2, columns = num_segments(size.width + 2);
  Grid node_x(num_segments(rows) + 3, columns + 3), node_y(num_segments(rows) + 3, columns + 3);
  const Vector2d nowhere = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Vector2d first_node = first.cast<double>() - Vector2d::Constant(1 + kSpacing);
  for (int j = 0; j < node_x.rows(); ++j) {
    for (int i = 0; i < node_x.cols(); ++i) {
      const Vector2d at = view.place(first_node + kSpacing * Vector2d(i, j)).value_or(nowhere);
      node_x(j, i) = static_cast<float>(at.x());
      node_y(j, i) = static_cast<float>(at.y());
    }
  }
  static const std::array<Segment, 4> weights = cubic_weights();
  Eigen::ArrayXf of_row;
  for (const auto& [nodes, places] : {std::pair{&node_x, &x_}, {&node_y, &y_}}) {
    places->resize(rows, columns * kSpacing);
    for (int r = 0; r < rows; ++r) {
      const int j = r / kSpacing, k = r % kSpacing;
      of_row = weights[0][k] * nodes->row(j) + weights[1][k] * nodes->row(j + 1) +
               weights[2][k] * nodes->row(j + 2) + weights[3][k] * nodes->row(j + 3);
      for (int i = 0; i < columns; ++i)
        places->row(r).segment<kSpacing>(kSpacing * i) =
            of_row[i] * weights[0] + of_row[i + 1] * weights[1] + of_row[i + 2] * weights[2] +
            of_row[i + 3] * weights[3];
    }
  }
}

// Computes the stretch from differences of neighbouring places.
void StraightPlaces::stretch(const ImageSize& size, double scale) {
  // Rows are read by whole packs, so that the last one needs room.
  for (Grid* values : {&xx_, &xy_, &yy_}) values->setZero(size.height + 1, x_.cols());
  const float per_px = static_cast<float>(scale) / 2;
  float largest = 1;
  for (int r = 0; r < size.height; ++r) {
    const auto across = [&](const Grid& v) {
      return per_px * (v.row(r + 1).segment(2, width_) - v.row(r + 1).head(width_));
    };
    const auto down = [&](const Grid& v) {
      return per_px * (v.row(r + 2).segment(1, width_) - v.row(r).segment(1, width_));
    };
    auto xx = xx_.row(r).head(width_), xy = xy_.row(r).head(width_), yy = yy_.row(r).head(width_);
    xx = across(x_).square() + down(x_).square();
    xy = across(x_) * across(y_) + down(x_) * down(y_);
    yy = across(y_).square() + down(y_).square();
    // Pixels without a place are left out.
    largest = std::max(largest, (xx.max(yy) + xy.abs()).maxCoeff<Eigen::PropagateNumbers>());
  }
  stretch_ = std::sqrt(static_cast<double>(largest));
}

}  // namespace tagcal::internal
