#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"

namespace tagcal::internal {

FormatOutput write_tum(const CameraFile& file) {
  if (file.poses.empty())
    throw Error("tum is a format of poses, and there are none: take a calibration with views");
  const PoseTimes times = times_of(file.poses);
  FormatOutput output;
  std::string text =
      fmt::format("# timestamp tx ty tz qx qy qz qw ({} from camera)\n", file.frame_of_poses);
  for (std::size_t i = 0; i < file.poses.size(); ++i) {
    const Pose world_from_camera = file.poses[i].camera_from_world.inverse();
    const Eigen::Quaterniond q = world_from_camera.rotation();
    const Eigen::Vector3d& t = world_from_camera.translation();
    text += fmt::format("{} {} {} {} {} {} {} {}\n", times.seconds[i], t.x(), t.y(), t.z(), q.x(),
                        q.y(), q.z(), q.w());
  }
  output.files = {{"", text}};
  output.notes.push_back(times.note);
  output.notes.emplace_back("dropped: the camera and the names of the pictures");
  return output;
}

}  // namespace tagcal::internal
