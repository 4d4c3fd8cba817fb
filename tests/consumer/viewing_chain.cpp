// The point of docs/course/viewing.md that is worked by hand: from its tag to the raster.
#include <cmath>
#include <cstdio>
#include <tagcal/geometry/viewpoint.hpp>
#include <tagcal/viewing/projection.hpp>
#include <tagcal/viewing/viewport.hpp>

int main() {
  const tagcal::Pose world_from_board =
      tagcal::translation({0.48, 0.64, 0}) * tagcal::rotation_about_z(-std::atan2(3, 4));
  const tagcal::Pose camera_from_world =
      tagcal::camera_from_world_looking_at({0, 0, 0.6}, {0.48, 0.64, 0}, {0, 0, 1});
  const tagcal::Camera camera{tagcal::pinhole(480, 480, 319.5, 239.5), {640, 480}};
  const tagcal::ViewVolume volume = tagcal::view_volume(camera, 0.6, 3);

  const Eigen::Vector3d x_in_board(0.25, 0.25, 0);
  const Eigen::Vector3d x_in_world = world_from_board * x_in_board;
  const Eigen::Vector3d x_in_camera = camera_from_world * x_in_world;
  const Eigen::Vector3d x_in_eye = tagcal::opengl_from_opencv() * x_in_camera;
  const Eigen::Vector4d x_in_clip = tagcal::clip_from_eye(volume) * x_in_eye.homogeneous();
  const auto x_in_ndc = tagcal::divided(x_in_clip);              // no value behind the eye
  const auto pixel = tagcal::project(camera.lens, x_in_camera);  // the same point through the lens
  if (!x_in_ndc || !pixel) return 1;
  const Eigen::Vector4d x_in_raster =
      tagcal::raster_from_ndc({camera.image_size}) * x_in_ndc->homogeneous();
  std::printf("world  %.4f %.4f\n", x_in_world.x(), x_in_world.y());
  std::printf("camera %.4f %.4f %.4f\n", x_in_camera.x(), x_in_camera.y(), x_in_camera.z());
  std::printf("clip   %.4f %.4f %.4f %.4f\n", x_in_clip.x(), x_in_clip.y(), x_in_clip.z(),
              x_in_clip.w());
  std::printf("ndc    %.4f %.4f %.4f\n", x_in_ndc->x(), x_in_ndc->y(), x_in_ndc->z());
  std::printf("raster %.4f %.4f, lens %.4f %.4f\n", x_in_raster.x(), x_in_raster.y(), pixel->x(),
              pixel->y());
}
