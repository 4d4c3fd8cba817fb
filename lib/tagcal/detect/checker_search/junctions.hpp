#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A place where two lines cross and opposite quarters have one colour.
struct Junction {
  Eigen::Vector2d at;
  // Directions of the lines, radians from the picture's x towards its y. The quarter from `first`
  // to `second`, 0 < second - first < pi, is white.
  double first = 0;
  double second = 0;
  double contrast = 0;  // grey levels between black and white
  double strength = 0;  // grey levels per px^2
};

// The junctions of a picture with a side of 16 px or more, strongest first: saddles of the smoothed
// picture about which a circle crosses four borders. Lines must be 3 px or more from the next ones.
std::vector<Junction> find_junctions(const ImageView8& image);

}  // namespace tagcal::internal
