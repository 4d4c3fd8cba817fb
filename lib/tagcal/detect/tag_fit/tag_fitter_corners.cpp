// Corners of a tag's fit, and their derivatives by its parameters.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {

using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace tag_parameter;

Vector2d TagFitter::straight_corner(std::size_t i) const {
  const TagParameters& p = model_.parameters();
  const Vector2d& on_tag = region_.corners_on_tag[i];
  const auto line = [&](int row, double at) {
    Vector3d result = p.segment<3>(row);
    result.head<2>() -= at * p.segment<2>(kM3);
    result.z() -= at;
    return result;
  };
  return line(kM1, on_tag.x()).cross(line(kM2, on_tag.y())).hnormalized();
}

// In the straightened view: a known lens is not applied.
Vector2d TagFitter::corner(std::size_t i) const {
  const TagParameters& p = model_.parameters();
  const Vector2d bent = straight_corner(i);
  Vector2d place = bent;
  for (int k = 0; k < 5; ++k)
    place = bent - bend_basis(place.x(), place.y()) * p.segment<kNumBends>(kBend);
  return place;
}

TagCornerJacobian TagFitter::corner_jacobian() const {
  const TagParameters& p = model_.parameters();
  TagCornerJacobian result = TagCornerJacobian::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    if (!is_in_region(i)) continue;
    const double u = region_.corners_on_tag[i].x(), v = region_.corners_on_tag[i].y();
    const Vector2d place = corner(i);
    const Eigen::Matrix<double, kNumBends, 1> bend = p.segment<kNumBends>(kBend);
    const BendBasis basis = bend_basis(place.x(), place.y());
    const Vector2d bent = place + basis * bend;
    Eigen::Matrix2d across;
    across.row(0) = p.segment<2>(kM1) - u * p.segment<2>(kM3);
    across.row(1) = p.segment<2>(kM2) - v * p.segment<2>(kM3);
    Eigen::Matrix<double, 2, kCount> by = Eigen::Matrix<double, 2, kCount>::Zero();
    by.row(0).segment<3>(kM1) = -bent.homogeneous();
    by.row(1).segment<3>(kM2) = -bent.homogeneous();
    by.row(0).segment<2>(kM3) = u * bent;
    by.row(1).segment<2>(kM3) = v * bent;
    by = (across.inverse() * by).eval();
    by.middleCols<kNumBends>(kBend) -= basis;
    Eigen::Matrix2d straight;        // bent place by place
    constexpr double kDelta = 1e-4;  // numeric: of differences, exact for cubics up to its square
    for (int k = 0; k < 2; ++k) {
      const Vector2d d = kDelta * Vector2d::Unit(k);
      const Vector2d more = place + d, less = place - d;
      straight.col(k) =
          Vector2d::Unit(k) +
          (bend_basis(more.x(), more.y()) - bend_basis(less.x(), less.y())) * bend / (2 * kDelta);
    }
    Eigen::Matrix2d pixels = region_.scale * Eigen::Matrix2d::Identity();
    if (view_) pixels = view_->pixel_by_place(place).value_or(pixels);
    result.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = pixels * straight.inverse() * by;
  }
  return result;
}

double TagFitter::third_order_px() const {
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d place = corner(i);
    const Vector2d moved =
        bend_basis(place.x(), place.y()).rightCols<8>() * model_.parameters().segment<8>(kBend + 4);
    largest = std::max(largest, region_.scale * moved.norm());
  }
  return largest;
}

bool TagFitter::is_in_region(std::size_t corner) const {
  return !region_.corner || *region_.corner == corner;
}

}  // namespace tagcal::internal
