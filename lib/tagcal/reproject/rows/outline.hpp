#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/camera/camera.hpp"

namespace tagcal::internal {

// The rays of a picture's outer border, a pixel apart, in order around it; where the border has no
// ray, the last one on the way to it from the principal point. Throws Error for a parallel lens,
// and if no ray is found.
std::vector<Eigen::Vector3d> outline_rays(const Camera& camera);

// The direction of a pixel's ray; where it has none, the last one on the way to it from the
// principal point. Precondition: the middle of the picture has a ray (outline_rays checks it).
Eigen::Vector3d ray_or_last(const Camera& camera, const Eigen::Vector2d& pixel);

// The rays of a grid of pixels over the picture, the border included, as far as they exist.
std::vector<Eigen::Vector3d> grid_rays(const Camera& camera);

}  // namespace tagcal::internal
