#include "tagcal/io/formats/tum_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/io/text/number_text.hpp"

namespace tagcal::internal {
namespace {

// The number that is the picture's name, in the digits of the name. 16 digits and more are
// nanoseconds (EuRoC), which become seconds. "" if the name is no number.
std::string time_of(const std::string& image) {
  const std::string stem = std::filesystem::path(image).stem().string();
  const bool digits = !stem.empty() && stem.find_first_not_of("0123456789.") == std::string::npos;
  if (!digits || !parse_number(stem)) return "";
  constexpr std::size_t kNanosecondDigits = 16;  // numeric: seconds since 1970 have 10 digits
  if (stem.find('.') != std::string::npos || stem.size() < kNanosecondDigits) return stem;
  return stem.substr(0, stem.size() - 9) + "." + stem.substr(stem.size() - 9);
}

}  // namespace

FormatOutput write_tum(const CameraFile& file) {
  if (file.poses.empty())
    throw Error("tum is a format of poses, and there are none: take a calibration with views");
  std::vector<std::string> times;
  for (const ImagePose& pose : file.poses) times.push_back(time_of(pose.image));
  const bool named = std::ranges::none_of(times, &std::string::empty) &&
                     std::set<std::string>(times.begin(), times.end()).size() == times.size();
  FormatOutput output;
  std::string text = "# timestamp tx ty tz qx qy qz qw (world from camera)\n";
  for (std::size_t i = 0; i < file.poses.size(); ++i) {
    const Pose world_from_camera = file.poses[i].camera_from_world.inverse();
    const Eigen::Quaterniond q = world_from_camera.rotation();
    const Eigen::Vector3d& t = world_from_camera.translation();
    text += fmt::format("{} {} {} {} {} {} {} {}\n", named ? times[i] : fmt::to_string(i), t.x(),
                        t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  output.files = {{"", text}};
  output.notes.emplace_back(named ? "timestamps are the names of the pictures, in seconds"
                                  : "timestamps are the numbers of the pictures, from 0: their "
                                    "names are no times");
  output.notes.emplace_back("dropped: the camera and the names of the pictures");
  return output;
}

}  // namespace tagcal::internal
