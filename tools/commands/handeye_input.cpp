#include "commands/handeye_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tagcal/error.hpp"
#include "tagcal/io/rig_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

std::string stem_of(const std::string& image) { return fs::path(image).stem().string(); }

// All pictures, also those without corners.
std::vector<std::string> pictures_of(const Input& input) {
  std::vector<std::string> names;
  for (const ImageSource& source : input.images) names.push_back(source.name);
  if (names.empty())
    for (const View& view : input.dataset.views) names.push_back(view.image);
  return names;
}

// The index of a picture by its name, or by its last part without the ending.
std::map<std::string, std::size_t> places_of(const std::vector<std::string>& names,
                                             const std::string& what) {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!places.emplace(stem_of(names[i]), i).second)
      throw Error(fmt::format("{}: two pictures have the name {}", what, stem_of(names[i])));
  return places;
}

// The pose of each picture by name.
std::map<std::string, Pose> poses_by_name(const Input& input, const std::string& robot,
                                          const RobotPoses& poses) {
  const std::vector<std::string> pictures = pictures_of(input);
  const auto places = places_of(pictures, input.name);
  std::map<std::string, Pose> by_name;
  for (std::size_t i = 0; i < poses.images.size(); ++i) {
    const std::string name = stem_of(poses.images[i]);
    // Corners alone do not say which pictures there were.
    if (!input.images.empty() && !places.contains(name))
      throw Error(fmt::format("{}: {} is no picture of {}", robot, poses.images[i], input.name));
    if (!by_name.emplace(name, poses.base_from_hand[i]).second)
      throw Error(fmt::format("{}: two poses have the picture {}", robot, name));
  }
  return by_name;
}

std::map<std::string, Pose> poses_by_order(const Input& input, const std::string& robot,
                                           const RobotPoses& poses) {
  std::vector<std::string> pictures = pictures_of(input);
  if (pictures.size() != poses.base_from_hand.size())
    throw Error(
        fmt::format("{}: has {} poses without names, but {} has {} pictures: name the "
                    "pictures in a column image",
                    robot, poses.base_from_hand.size(), input.name, pictures.size()));
  std::ranges::sort(pictures, {}, [](const std::string& p) { return order_of_numbers(p); });
  places_of(pictures, input.name);
  std::map<std::string, Pose> by_name;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    by_name.emplace(stem_of(pictures[i]), poses.base_from_hand[i]);
  return by_name;
}

}  // namespace

std::vector<HandeyeView> with_robot_poses(const Input& input, std::vector<HandeyeView> views,
                                          const std::string& robot, const RobotPoses& poses,
                                          const std::string& times, HandeyeOptions& options) {
  if (!poses.times_s.empty()) {
    if (times.empty())
      throw Error(
          fmt::format("{}: has poses by time: give the pictures' times with --times "
                      "(image,time_s)",
                      robot));
    const std::map<std::string, double> times_s = read_picture_times(times);
    for (HandeyeView& view : views) {
      const auto found = times_s.find(fs::path(view.image).filename().string());
      if (found == times_s.end())
        throw Error(fmt::format("{}: has no time of the picture {}", times, view.image));
      view.time_s = found->second;
    }
    options.path = RobotPath{poses.times_s, poses.base_from_hand};
    return views;
  }
  if (!times.empty() || options.find_time_offset)
    throw Error(
        fmt::format("{}: has no times (a column time_s), which --times and --time-offset "
                    "need",
                    robot));
  const auto by_name = poses.images.empty() ? poses_by_order(input, robot, poses)
                                            : poses_by_name(input, robot, poses);
  for (HandeyeView& view : views) {
    const auto found = by_name.find(stem_of(view.image));
    if (found == by_name.end())
      throw Error(fmt::format("{}: has no pose of the picture {}", robot, view.image));
    view.base_from_hand = found->second;
  }
  return views;
}

}  // namespace tagcal::tools
