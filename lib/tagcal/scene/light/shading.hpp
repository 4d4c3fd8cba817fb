#pragma once

#include <optional>

#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal::internal {

// The light in the coordinates of another frame, in which distances are the same.
Light in_frame(const Pose& target_from_source, Light light);

// The light of a scene in the camera frame of a view.
std::optional<Light> light_in_camera(const Scene& scene, const Pose& camera_from_world);

// The factor by which light changes the level of one side of a flat sheet. With the lamp at height
// h above the plane, the cosine at a point at distance r is h / r, and the lamp adds
// strength * h / r^3. All lengths are in one frame, and the factor is the same in any.
class Shading {
 public:
  Shading() = default;  // 1 everywhere

  // The normal has length 1 and points to the side that is seen; x is any point of the sheet.
  Shading(const Light& light, const Eigen::Vector3d& normal, const Eigen::Vector3d& x);

  bool is_uniform() const { return point_gain_ == 0; }
  double uniform() const { return uniform_; }  // without the point lamp
  double at(const Eigen::Vector3d& x_on_sheet) const;

  // At the point of the plane that a ray meets. A ray from the eye that misses the plane is close
  // to its horizon, where the lamp adds nothing.
  double at(const Ray& ray) const;

 private:
  double uniform_ = 1;
  double point_gain_ = 0;  // strength * h
  Eigen::Vector3d lamp_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_ = Eigen::Vector3d::Zero();
  double offset_ = 0;  // normal . x of the plane
};

// Multiplies the light at each pixel by its vignetting. Throws Error as check_sensor for the pixels
// of the image; check_vignetting tests all of them.
void check_vignetting(const Camera& camera, const Vignetting& vignetting);
void vignette(const Camera& camera, const Vignetting& vignetting, ImageF& light);

}  // namespace tagcal::internal
