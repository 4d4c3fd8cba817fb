// Projects points, with the derivatives of each pixel by the pose and the lens.
#include <array>
#include <iostream>
#include <tagcal/camera/batch.hpp>
#include <vector>

int main() {
  const tagcal::Lens lens = tagcal::pinhole(600, 600, 319.5, 239.5);
  const tagcal::Pose camera_from_board;  // the identity: the points are in the camera's frame
  const std::array<Eigen::Vector3d, 2> points = {{{0.1, 0, 2}, {0.1, 0, -2}}};
  const auto& free = tagcal::Model::named("pinhole").free();  // fx fy cx cy

  std::array<Eigen::Vector2d, 2> pixels;
  std::array<std::uint8_t, 2> valid;
  std::vector<double> by_pose(4 * 6);  // rows: u and v of each point; (omega, tau) of `retract`
  std::vector<double> by_parameters(4 * free.size());
  tagcal::project_with_jacobians(lens, camera_from_board, points, free,
                                 {pixels, valid, by_pose, by_parameters});
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (valid[i] == 0) {
      std::cout << "no pixel: behind the camera\n";
      continue;
    }
    std::cout << pixels[i].transpose() << ", du/dtx " << by_pose[2 * i * 6 + 3] << ", du/dfx "
              << by_parameters[2 * i * free.size()] << "\n";
  }
}
