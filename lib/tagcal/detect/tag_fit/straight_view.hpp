#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/camera/camera.hpp"

// Private to detect: a known lens in refine_tag().
namespace tagcal::internal {

// Straightened places of a row's pixels, the input of the homography, by column.
struct RowPlaces {
  const float* x = nullptr;
  const float* y = nullptr;
  // Entries of J J^T, J the Jacobian of the places by the pixels, in px per px: how places are
  // stretched against pixels; and the largest stretch.
  const float* xx = nullptr;
  const float* xy = nullptr;
  const float* yy = nullptr;
  double stretch = 1;
};

// The picture around a pixel as a pinhole camera that faces it would see it, where straight lines
// are straight. Places have the unit `scale` px and their origin at that pixel; there,
// counted in px, their Jacobian by the pixels is the identity.
class StraightView {
 public:
  // No value if the pixel has no ray. Precondition: the rays of the lens meet in one point.
  static std::optional<StraightView> about(const Lens& lens, const Eigen::Vector2d& middle,
                                           double scale);

  std::optional<Eigen::Vector2d> place(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& place) const;
  // Jacobian of the pixel by the place, px per unit, by differences.
  std::optional<Eigen::Matrix2d> pixel_by_place(const Eigen::Vector2d& place) const;

 private:
  std::optional<Eigen::Vector2d> tangent(const Eigen::Vector2d& pixel) const;

  Lens lens_ = pinhole(1, 1, 0, 0);
  Eigen::Matrix3d view_from_camera_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix2d tangent_from_place_ = Eigen::Matrix2d::Identity();
};

// The places of a block of pixels, row by row, interpolated by cubics from those of every eighth
// pixel; NaN for pixels without a ray.
class StraightPlaces {
 public:
  // One unit of the places is `scale` px.
  StraightPlaces(const StraightView& view, const Eigen::Vector2i& first, const ImageSize& size,
                 double scale);
  RowPlaces row(int row) const;

 private:
  void place(const StraightView& view, const Eigen::Vector2i& first, const ImageSize& size);
  void stretch(const ImageSize& size, double scale);

  using Grid = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  int width_;
  double stretch_ = 1;
  Grid x_, y_;  // see RowPlaces; with a pixel more on each side
  Grid xx_, xy_, yy_;
};

}  // namespace tagcal::internal
