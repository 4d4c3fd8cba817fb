#pragma once

#include <map>
#include <optional>
#include <vector>

#include "study/method.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"

// Detection of the centres of a grid of circles under a strong lens, by ours and by OpenCV. Private
// to study.

namespace tagcal::study {

struct CircleTask {
  Camera camera;
  PlacedBoard board;
  Image8 image;
  std::map<int, Eigen::Vector2d> centres;  // true ones, by id
  double bound_px = 0;  // Cramer-Rao bound under the known lens, RMS of a coordinate
};

// A grid of 8 x 6 circles, 24 px apart before a tilt of up to 60 degrees, through a barrel lens
// with k1 = -0.4, black 30, white 220.
CircleTask draw_circle_task(double noise_levels, Random& random);

using CircleMethod = Method<CircleTask, std::vector<Eigen::Vector2d>>;

// By cv::findCirclesGrid; none if it finds no grid.
std::vector<Eigen::Vector2d> circles_by_opencv(const Image8& image, const CircleGrid& grid);

// As `tagcal detect`, also with --camera, and cv::findCirclesGrid. No centres: not found.
std::vector<CircleMethod> circle_methods();

}  // namespace tagcal::study
