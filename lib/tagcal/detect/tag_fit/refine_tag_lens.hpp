#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tagcal/camera/camera.hpp"

// Private to detect: what refine_tag() knows of a lens.
namespace tagcal::internal {

// Where the pixels of a row are before the homography, by their number.
struct RowPlaces {
  const float* x = nullptr;
  const float* y = nullptr;
  // Squares and product of the slopes of x and y over the picture, in px per px, where places are
  // stretched against pixels; and their largest stretch.
  const float* xx = nullptr;
  const float* xy = nullptr;
  const float* yy = nullptr;
  double stretch = 1;
};

// The picture about a place as a pinhole that faces it would see it: there straight lines are
// straight. Places are in units of `scale` px, (0, 0) in the middle, where they turn and stretch as
// the pixels do.
class StraightView {
 public:
  // No value where the pixel has no ray. The rays of a lens must meet in one point.
  static std::optional<StraightView> about(const Lens& lens, const Eigen::Vector2d& middle,
                                           double scale);

  std::optional<Eigen::Vector2d> place(const Eigen::Vector2d& pixel) const;
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& place) const;
  // Pixel by place, px per unit; by differences.
  std::optional<Eigen::Matrix2d> pixel_by_place(const Eigen::Vector2d& place) const;

 private:
  std::optional<Eigen::Vector2d> tangent(const Eigen::Vector2d& pixel) const;

  Lens lens_ = pinhole(1, 1, 0, 0);
  Eigen::Matrix3d view_from_camera_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix2d tangent_from_place_ = Eigen::Matrix2d::Identity();
};

// The places of a block of pixels, row by row, from those of every eighth by cubics; NaN where
// there are none.
class StraightPlaces {
 public:
  // One unit of the places is `scale` px.
  StraightPlaces(const StraightView& view, const Eigen::Vector2i& first, const ImageSize& size,
                 double scale);
  RowPlaces row(int row) const;

 private:
  void place(const StraightView& view, const Eigen::Vector2i& first, const ImageSize& size);
  void stretch(const ImageSize& size, double scale);

  int width_;
  double stretch_ = 1;
  std::vector<float> x_, y_, xx_, xy_, yy_;  // as in RowPlaces
};

}  // namespace tagcal::internal
