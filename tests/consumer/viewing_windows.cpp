// One point by four projections; a window before a moving eye; a wall of displays.
#include <cstdio>
#include <numbers>
#include <tagcal/viewing/projection.hpp>
#include <tagcal/viewing/viewport.hpp>

namespace {

void print(const char* name, const Eigen::Matrix4d& projection, const Eigen::Vector3d& x) {
  const auto drawn = tagcal::divided(projection * x.homogeneous());
  if (drawn) std::printf("%-12s %7.4f %7.4f\n", name, drawn->x(), drawn->y());
}

}  // namespace

int main() {
  // A point 0.3 m to the right, 0.15 m up and 0.4 m behind the plane of the drawing.
  const Eigen::Vector3d x(0.3, -0.15, 0.4);
  constexpr double kRecedes = std::numbers::pi / 4;
  print("perspective", tagcal::perspective_from_behind(1.6), x);
  print("orthographic", tagcal::orthographic_projection(), x);
  print("cavalier", tagcal::cavalier_projection(kRecedes), x);
  print("cabinet", tagcal::cabinet_projection(kRecedes), x);
  const Eigen::Vector3d edge =
      tagcal::camera_from_world_drawn(tagcal::DrawnView::isometric) * Eigen::Vector3d::UnitX();
  std::printf("isometric    an edge of 1 m is drawn %.4f m long\n", edge.head<2>().norm());

  // An eye 0.2 m to the right of the middle of a display of 0.6 m x 0.4 m, and 0.5 m before it.
  const tagcal::CameraBehindWindow seen = tagcal::camera_behind(
      {{-0.3, 0, -0.2}, {0.3, 0, -0.2}, {-0.3, 0, 0.2}}, {0.2, -0.5, 0}, {600, 400});
  const tagcal::Window window = tagcal::view_volume(seen.camera, 0.5, 5).window;
  std::printf("window       left %.4f right %.4f bottom %.4f top %.4f\n", window.left, window.right,
              window.bottom, window.top);

  // The upper right display of a wall of 2 x 2.
  const tagcal::Camera whole{tagcal::pinhole(480, 480, 319.5, 239.5), {640, 480}};
  const tagcal::Camera part = tagcal::cropped(whole, tagcal::sectors(whole.image_size, 2, 2)[1]);
  const Eigen::Matrix4d clip = tagcal::clip_from_eye(tagcal::view_volume(part, 0.6, 3));
  std::printf("wall         first row %.4f %.4f %.4f, second row %.4f %.4f %.4f\n", clip(0, 0),
              clip(0, 1), clip(0, 2), clip(1, 0), clip(1, 1), clip(1, 2));
}
