// Renders a picture of a board, with the exact corners in it.
#include <iostream>
#include <tagcal/detect/families.hpp>
#include <tagcal/geometry/viewpoint.hpp>
#include <tagcal/io/image_file.hpp>
#include <tagcal/scene/render.hpp>
#include <tagcal/scene/viewing.hpp>

int main() {
  const tagcal::AprilGrid grid{.columns = 4,
                               .rows = 3,
                               .tag_size = 0.06,
                               .tag_spacing = 0.3,
                               .border_bits = 1,
                               .corner_squares = false};
  tagcal::Scene scene;
  scene.camera = {tagcal::pinhole(600, 600, 319.5, 239.5), {640, 480}};
  scene.boards = {{tagcal::make_board(grid), tagcal::Pose()}};
  scene.sensor = {.blur_px = 0.7, .noise_levels = 2};
  const tagcal::Pose camera_from_world =
      tagcal::camera_from_world_looking_at({0.2, -0.2, 0.4}, {0.147, 0.108, 0}, {0, 0, 1});

  const tagcal::TagFamilies families = {{"tag36h11", tagcal::tag_family("tag36h11", 1)}};
  const tagcal::ImageF light = tagcal::render_light(scene, families, camera_from_world);
  tagcal::write_png("board.png", tagcal::expose(light, scene.sensor, 1));
  const std::vector<tagcal::Observation> corners =
      tagcal::visible_corners(scene, camera_from_world);
  if (corners.empty()) return 1;
  std::cout << corners.size() << " corners, the first at " << corners[0].pixel.transpose() << "\n";
}
