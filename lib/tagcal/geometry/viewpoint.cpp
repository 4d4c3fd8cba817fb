#include "tagcal/geometry/viewpoint.hpp"

#include "tagcal/error.hpp"

namespace tagcal {

Pose camera_from_world_looking_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                                  const Eigen::Vector3d& up) {
  const Eigen::Vector3d view = target - eye;
  if (!(view.norm() > 0)) throw Error("look-at: the eye and the target coincide");
  const Eigen::Vector3d forward = view.normalized();
  const Eigen::Vector3d right = forward.cross(up);
  if (!(right.norm() > 1e-9 * up.norm())) throw Error("look-at: up is parallel to the view");
  Eigen::Matrix3d world_from_camera;
  world_from_camera.col(0) = right.normalized();
  world_from_camera.col(1) = forward.cross(world_from_camera.col(0));  // down
  world_from_camera.col(2) = forward;
  return Pose(Eigen::Quaterniond(world_from_camera), eye).inverse();
}

}  // namespace tagcal
