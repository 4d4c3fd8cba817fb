#include "tagcal/camera/lens.hpp"

namespace tagcal {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Ray> Parallel::ray_in_camera(const Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  return Ray{{(pixel.x() - p_[2]) / p_[0], (pixel.y() - p_[3]) / p_[1], 0},
             Vector3d(-p_[4], -p_[5], 1).normalized()};
}

}  // namespace tagcal
