#pragma once

#include <Eigen/Core>
#include <optional>

#include "tagcal/geometry/pose.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// The board about a disc's centre in the picture, to second order: x from the centre, in units in
// which the next centre is at a distance of 1, is at  centre + first x + second (x^2, xy, y^2).
// The terms of second order move the disc's centre of gravity away from the image of its centre
// (Heikkila, PAMI 2000, for perspective; Mateos, CVWW 2000): the fit of a disc by a map that has
// them reports the image of the centre.
struct LocalMap {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Matrix2d first = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 2, 3> second = Eigen::Matrix<double, 2, 3>::Zero();

  Eigen::Vector2d pixel(const Eigen::Vector2d& x) const;
  Eigen::Vector2d of_second_order(const Eigen::Vector2d& x) const;
  Eigen::Matrix2d derivative(const Eigen::Vector2d& x) const;
  // The place whose pixel it is, for places up to 1 from the centre.
  Eigen::Vector2d place(const Eigen::Vector2d& pixel) const;
};

struct CircleFit {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // image of the disc's centre
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  double radius = 0;  // distances of centres
};

// Fits the grey levels about a dark disc: the image of a circle of unknown radius under the map,
// moved, blurred by a Gaussian and the pixel's square, with one level of ink, and one of paper that
// changes linearly. The covariance is from the residuals. Pixels up to half the distance to the
// next centre, and up to 16 px from the border, are used. No value if the picture does not show
// such a disc within a third of the distance of its place, or not wholly.
std::optional<CircleFit> fit_circle(const ImageView8& image, const LocalMap& map);

}  // namespace tagcal::internal
