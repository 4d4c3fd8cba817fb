// The closed forms and minimal solvers, on what a camera at a known place sees.
#include <array>
#include <iostream>
#include <tagcal/random.hpp>
#include <tagcal/solvers/n_point.hpp>
#include <tagcal/solvers/p3p.hpp>
#include <tagcal/solvers/plane.hpp>
#include <tagcal/solvers/weak_perspective.hpp>

int main() {
  const tagcal::Pose truth({0.1, 0.9, 0.3, 0.2}, {0.02, -0.03, 0.6});
  tagcal::Random random(1);
  std::array<Eigen::Vector3d, 6> points, rays;  // in the target's frame, in the camera's
  std::array<Eigen::Vector2d, 6> pixels;        // from the principal point, f = 600 px
  std::array<Eigen::Vector2d, 4> plane;
  std::array<Eigen::Vector3d, 4> plane_rays;
  std::array<Eigen::Vector2d, 4> plane_pixels;
  for (std::size_t i = 0; i < 6; ++i) {
    for (double& x : points[i]) x = random.uniform(-0.1, 0.1);
    rays[i] = truth * points[i];
    pixels[i] = 600 * rays[i].hnormalized();
  }
  for (std::size_t i = 0; i < 4; ++i) {
    plane[i] = points[i].head<2>();
    plane_rays[i] = truth * Eigen::Vector3d(plane[i].x(), plane[i].y(), 0);
    plane_pixels[i] = 600 * plane_rays[i].hnormalized();
  }
  const auto show = [&](const char* name, const tagcal::Pose& pose) {
    std::cout << name << " " << tagcal::angle_between_rad(pose, truth) << " rad off\n";
  };

  // solvers/p3p.hpp: three rays, up to four poses, as solvers/solutions.hpp
  for (const tagcal::Pose& pose :
       tagcal::p3p(std::span(points).first<3>(), std::span(rays).first<3>()))
    show("p3p", pose);
  // solvers/p4pf.hpp: four pixels, pose and focal length
  for (const tagcal::PoseAndFocal& found :
       tagcal::p4pf(std::span(points).first<4>(), std::span(pixels).first<4>()))
    show("p4pf", found.camera_from_target);
  // solvers/n_point.hpp: three rays and more, the minima, best first
  show("pnp", tagcal::pnp(points, rays).front());
  // solvers/plane.hpp: homography, both poses of a plane; pose and focal length
  if (const auto homography = tagcal::homography(plane, plane_rays))
    for (const tagcal::Pose& pose : tagcal::ippe(*homography)) show("ippe", pose);
  if (const auto found = tagcal::plane_pose_and_focal(plane, plane_pixels))
    show("plane, unknown focal length", found->camera_from_target);
  // solvers/weak_perspective.hpp: what is left without a focal length, scale f / Z
  for (const tagcal::WeakPerspectivePose& weak : tagcal::weak_perspective_poses(points, pixels))
    std::cout << "weak perspective " << weak.scale_px_per_m << " px/m\n";
}
