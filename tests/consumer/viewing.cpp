// One point from an object to a pixel: through the lens, and through a renderer's matrices.
#include <iostream>
#include <tagcal/geometry/viewpoint.hpp>
#include <tagcal/viewing/clip.hpp>
#include <tagcal/viewing/frames.hpp>
#include <tagcal/viewing/projection.hpp>
#include <tagcal/viewing/viewport.hpp>

int main() {
  // viewing/frames.hpp and geometry/transform.hpp: a cup on a table
  const tagcal::Frames<tagcal::Pose> frames(
      "world",
      {{"table", "world", tagcal::translation({1, 0, 0.8})},
       {"cup", "table", tagcal::rotation_about_z(0.5) * tagcal::translation({0.2, 0, 0})}});
  const Eigen::Vector3d handle = frames.a_from_b("world", "cup") * Eigen::Vector3d(0.05, 0, 0.04);
  // geometry/viewpoint.hpp: a camera on an orbit about the table
  const tagcal::Pose camera_from_world = tagcal::camera_from_world_on_orbit(
      {.target = {1, 0, 0.8}, .distance_m = 2, .azimuth_rad = 0.3, .elevation_rad = 0.6});
  const tagcal::Camera camera{tagcal::pinhole(600, 600, 319.5, 239.5), {640, 480}};
  const auto pixel = tagcal::project(camera.lens, camera_from_world * handle);

  // viewing/canonical.hpp: the same camera as OpenGL's matrix
  const Eigen::Matrix4d clip_from_eye = tagcal::clip_from_eye(tagcal::view_volume(camera, 0.1, 10));
  const Eigen::Vector4d x_in_clip =
      clip_from_eye * (tagcal::opengl_from_opencv() * camera_from_world * handle).homogeneous();
  // viewing/clip.hpp and viewing/projection.hpp: inside -w <= x, y, z <= w? then divide by w
  const auto x_in_ndc = tagcal::divided(x_in_clip);
  if (!pixel || !x_in_ndc || !tagcal::in_clip_volume(x_in_clip)) return 1;
  // viewing/viewport.hpp: to the raster; and the camera of a picture half as large
  const Eigen::Vector4d x_in_raster =
      tagcal::raster_from_ndc({camera.image_size}) * x_in_ndc->homogeneous();
  const tagcal::Camera half = tagcal::resized(camera, {320, 240});
  std::cout << "lens " << pixel->transpose() << "\nmatrices " << x_in_raster.head<2>().transpose()
            << "\nhalf the size: f " << tagcal::parameters(half.lens)[0] << "\n";
}
