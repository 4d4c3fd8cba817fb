// The program of the README: where is a tag of 80 mm, whose corners are seen at these pixels?
#include <iostream>
#include <tagcal/estimate/pose.hpp>
#include <vector>

int main() {
  const tagcal::Camera camera{tagcal::pinhole(600, 600, 319.5, 239.5), {640, 480}};
  const double half = 0.04;  // metres; corners: lower-left, lower-right, upper-right, upper-left
  const std::vector<tagcal::Correspondence> seen = {{{-half, -half, 0}, {308.0, 244.3}},
                                                    {{half, -half, 0}, {381.5, 253.3}},
                                                    {{half, half, 0}, {378.7, 164.6}},
                                                    {{-half, half, 0}, {302.7, 162.1}}};
  const tagcal::PoseEstimate pose = tagcal::estimate_pose(seen, camera, {.sigma_px = 0.1});
  if (!tagcal::is_answer(pose.status)) return 1;
  std::cout << "tag in camera [m]: " << pose.camera_from_target().translation().transpose() << "\n";
}
