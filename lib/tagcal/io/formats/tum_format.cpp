#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

// The number that is the picture's name, in the digits of the name. "" if the name is no number.
std::string time_in_name(const ImagePose& pose) {
  const std::string stem = std::filesystem::path(pose.image).stem().string();
  const bool digits = !stem.empty() && stem.find_first_not_of("0123456789.") == std::string::npos;
  if (!digits || !parse_number(stem)) return "";
  constexpr std::size_t kNanosecondDigits = 16;  // numeric: seconds since 1970 have 10 digits
  if (stem.find('.') != std::string::npos || stem.size() < kNanosecondDigits) return stem;
  return stem.substr(0, stem.size() - 9) + "." + stem.substr(stem.size() - 9);
}

std::string own_time(const ImagePose& pose) {
  return pose.time_s && *pose.time_s >= 0 ? fmt::format("{:.6f}", *pose.time_s) : "";
}

}  // namespace

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

PoseTimes times_of(const std::vector<ImagePose>& poses) {
  PoseTimes times;
  const auto take = [&](std::string (*time)(const ImagePose&), const char* note) {
    times = {{}, note};
    for (const ImagePose& pose : poses) times.seconds.push_back(time(pose));
    return std::ranges::none_of(times.seconds, &std::string::empty) &&
           std::set<std::string>(times.seconds.begin(), times.seconds.end()).size() == poses.size();
  };
  if (take(own_time, "timestamps are the times of the pictures") ||
      take(time_in_name, "timestamps are the names of the pictures, in seconds"))
    return times;
  times.note = "timestamps are the numbers of the pictures, from 0: their names are no times";
  for (std::size_t i = 0; i < poses.size(); ++i) times.seconds[i] = fmt::to_string(i);
  return times;
}

}  // namespace tagcal::internal
