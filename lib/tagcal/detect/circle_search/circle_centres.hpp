#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect: the centres of one grid of circles in one picture.
namespace tagcal::internal {

struct CircleCentre {
  Eigen::Vector2d on_board;                                  // distances of centres
  Eigen::Vector2d at;                                        // px
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  // zero: not fitted
};

using CircleCentres = std::map<int, CircleCentre>;  // by id

// The centres of a grid on its board, at no place in the picture yet.
CircleCentres centres_on_board(const CircleGrid& grid);

// Fits each disc at its approximate place, in rounds: the image of a disc is predicted by its
// neighbours, first under the homography of the nearest ones, then also under the lens that all of
// them show together (lens_of_panel), or under the camera if it is not null. Where no lens is
// known, because the centres are too few, the covariance has what a usual lens may move. Returns
// the number of fitted centres; the others remain as they are, without covariance.
int fit_centres(const ImageView8& image, const Camera* camera, CircleCentres& centres);

}  // namespace tagcal::internal
