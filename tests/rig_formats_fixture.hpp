#pragma once

#include "camera_files.hpp"
#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"

// Random rigs, and the files of other programs that hold them.

namespace tagcal {

class RigFormats : public FileTest {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  // The message of reading, without the folder.
  std::string error(const std::string& name) const {
    return error_about(folder_.string() + "/", [&] { read_camera_file(folder_ / name); });
  }
};

// Cameras at places with numbers of 17 digits; the first one is the reference, unless the rig is an
// IMU.
inline CameraFile random_rig(Random& random, std::size_t num_cameras, bool on_imu = false) {
  const char* const names[] = {"a-left", "b-right", "c-up", "d-rear"};
  CameraFile file;
  file.format = "tagcal";
  file.rig_is_imu = on_imu;
  for (std::size_t i = 0; i < num_cameras; ++i) {
    FileCamera camera;
    camera.name = names[i];
    const double f = 400 + 10 * random.normal();
    camera.calibration.camera = {
        Perspective({f, f + 1, 320 + random.normal(), 240 + random.normal(), -0.1 / 3, 0.02, 5e-4,
                     -1e-5 / 3}),
        {640, 480}};
    const Eigen::Vector3d t(random.normal(), random.normal(), random.normal());
    if (i == 0 && !on_imu)
      camera.camera_from_rig = Pose();
    else
      camera.camera_from_rig = Pose(pose_of_many_sizes(random).rotation(), t);
    file.cameras.push_back(camera);
  }
  return file;
}

inline Pose from_first(const CameraFile& file, std::size_t i) {
  return *file.cameras[i].camera_from_rig * file.cameras[0].camera_from_rig->inverse();
}

}  // namespace tagcal
