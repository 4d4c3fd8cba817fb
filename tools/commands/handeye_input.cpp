#include "commands/handeye_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "commands/rig_poses.hpp"
#include "job/find_corners.hpp"
#include "report/pose_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/rig_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

std::string stem_of(const std::string& image) { return fs::path(image).stem().string(); }

// The index of a picture by its name, or by its last part without the ending.
std::map<std::string, std::size_t> places_of(const std::vector<std::string>& names,
                                             const std::string& what) {
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!places.emplace(stem_of(names[i]), i).second)
      throw Error(fmt::format("{}: two pictures have the name {}", what, stem_of(names[i])));
  return places;
}

// The number of the pose of each picture by name.
std::map<std::string, std::size_t> poses_by_name(const HandeyeInput& input,
                                                 const std::string& robot,
                                                 const RobotPoses& poses) {
  const auto places = places_of(input.pictures, input.name);
  std::map<std::string, std::size_t> by_name;
  for (std::size_t i = 0; i < poses.images.size(); ++i) {
    const std::string name = stem_of(poses.images[i]);
    if (input.has_all_pictures && !places.contains(name))
      throw Error(fmt::format("{}: {} is no picture of {}", robot, poses.images[i], input.name));
    if (!by_name.emplace(name, i).second)
      throw Error(fmt::format("{}: two poses have the picture {}", robot, name));
  }
  return by_name;
}

std::map<std::string, std::size_t> poses_by_order(const HandeyeInput& input,
                                                  const std::string& robot,
                                                  const RobotPoses& poses) {
  std::vector<std::string> pictures = input.pictures;
  if (pictures.size() != poses.base_from_hand.size())
    throw Error(
        fmt::format("{}: has {} poses without names, but {} has {} pictures: name the "
                    "pictures in a column image",
                    robot, poses.base_from_hand.size(), input.name, pictures.size()));
  std::ranges::sort(pictures, {}, [](const std::string& p) { return order_of_numbers(p); });
  places_of(pictures, input.name);
  std::map<std::string, std::size_t> by_name;
  for (std::size_t i = 0; i < pictures.size(); ++i) by_name.emplace(stem_of(pictures[i]), i);
  return by_name;
}

// The views with a corner of the target.
HandeyeInput read_pictures(const HandeyeSources& arguments) {
  auto [input, camera] =
      read_camera_views(arguments.input, arguments.camera, arguments.pair, arguments.threads);
  HandeyeInput read;
  read.name = input.name;
  read.has_all_pictures = !input.images.empty();
  read.camera = uncertain_camera(camera);
  read.image_size = camera.camera.image_size;
  for (const ImageSource& source : input.images) read.pictures.push_back(source.name);
  read.boards = in_frame_of_poses(input.dataset.boards);
  const auto points = points_in_world(read.boards);
  for (const View& view : input.dataset.views) {
    if (!read.has_all_pictures) read.pictures.push_back(view.image);
    if (view.observations.empty()) continue;
    read.views.push_back(
        {view.image, view_correspondences(view, points, camera.camera_error_px), {}, {}});
    read.views.back().time_s = time_of(input, view.image);
  }
  read.wrong_target = wrong_target(input.mistakes);
  if (read.camera->model)
    read.contradiction = contradiction_of_camera(input.dataset, *read.camera,
                                                 static_cast<std::size_t>(arguments.threads));
  return read;
}

// The camera whose frame is that of the rig, which the pictures may lack.
void set_reference(const KnownRig& rig, HandeyeInput& read) {
  const auto camera = rig.reference();
  read.reference = camera ? rig.cameras[*camera].name : "";
  if (camera) read.image_size = rig.cameras[*camera].camera.camera.image_size;
}

// An instant has the name of its first picture.
HandeyeInput read_rig_poses(const HandeyeSources& arguments) {
  const RigInputArguments rig = rig_arguments(arguments.input, arguments.pair, arguments.threads);
  const CameraFile file = read_camera_file(arguments.camera);
  const RigInput pictures = read_rig_for_poses(rig, file, arguments.camera);
  const RigDataset& data = pictures.rig;
  const KnownRig known = rig_of(data, file, arguments.camera);
  PoseOptions options;
  options.sigma_px = arguments.sigma_px;
  HandeyeInput read;
  read.name = arguments.input.inputs.front();
  read.has_all_pictures = false;
  read.shared = known.covariance;
  read.wrong_target = wrong_target(pictures.mistakes);
  set_reference(known_rig(file, arguments.camera), read);
  read.boards = data.cameras.front().data.boards;
  read.views.resize(data.instants.size());
  internal::parallel_for(
      read.views.size(), static_cast<std::size_t>(arguments.threads), [&](std::size_t t) {
        const RigPoseEstimate pose =
            estimate_rig_pose(seen_at(data.instants[t], data, known), known, options);
        if (is_answer(pose.rig.status)) read.views[t].poses = pose.parts;
        read.views[t].findings = pose.rig.findings;
        read.views[t].time_s = time_of(data.instants[t], data);
      });
  for (std::size_t t = 0; t < read.views.size(); ++t) {
    const auto& views = data.instants[t].view;
    const auto first = std::ranges::find_if(views, [](const auto& v) { return v.has_value(); });
    const auto camera = static_cast<std::size_t>(first - views.begin());
    read.views[t].image = data.cameras[camera].data.views[**first].image;
    read.pictures.push_back(read.views[t].image);
  }
  return read;
}

HandeyeInput read_poses(const HandeyeSources& arguments) {
  const std::string& file = arguments.input.inputs.front();
  for (const auto& [option, value] :
       {std::pair("--camera", arguments.camera), std::pair("--target", arguments.input.target),
        std::pair("--observations", arguments.input.observations)})
    if (!value.empty()) throw Error(fmt::format("{}: {} has poses, which need none", option, file));
  if (arguments.pair != "name") throw Error("--pair: needs the file of a rig");
  HandeyeInput read;
  read.name = file;
  read.views = read_pose_file(file);
  for (const HandeyeView& view : read.views) read.pictures.push_back(view.image);
  places_of(read.pictures, file);
  return read;
}

// The pictures' times: those of a file, or their own.
void add_times(const std::string& robot, const std::string& times, HandeyeInput& input) {
  if (times.empty()) {
    if (!std::ranges::all_of(input.views, [](const auto& view) { return view.time_s.has_value(); }))
      throw Error(
          fmt::format("{}: has poses by time: give the pictures' times with --times "
                      "(image,time_s)",
                      robot));
    return;
  }
  const std::map<std::string, double> times_s = read_picture_times(times);
  for (HandeyeView& view : input.views) {
    const auto found = times_s.find(fs::path(view.image).filename().string());
    if (found == times_s.end())
      throw Error(fmt::format("{}: has no time of the picture {}", times, view.image));
    view.time_s = found->second;
  }
}

}  // namespace

HandeyeInput read_handeye(const HandeyeSources& arguments) {
  const std::vector<std::string>& inputs = arguments.input.inputs;
  if (inputs.size() == 1 && fs::path(inputs[0]).extension() == ".json")
    return read_poses(arguments);
  if (arguments.camera.empty())
    throw Error("--camera: is missing, which only poses (tagcal pose --json) do not need");
  return is_rig_file(arguments.camera) ? read_rig_poses(arguments) : read_pictures(arguments);
}

void add_robot_poses(const std::string& robot, const RobotPoses& poses, const std::string& times,
                     HandeyeInput& input, HandeyeOptions& options) {
  options.robot_form = poses.form;
  if (!poses.times_s.empty()) {
    add_times(robot, times, input);
    options.path = RobotPath{poses.times_s, poses.base_from_hand};
    return;
  }
  if (!times.empty() || options.find_time_offset)
    throw Error(
        fmt::format("{}: has no times (a column time_s), which --times and --time-offset "
                    "need",
                    robot));
  const auto by_name = poses.images.empty() ? poses_by_order(input, robot, poses)
                                            : poses_by_name(input, robot, poses);
  for (HandeyeView& view : input.views) {
    const auto found = by_name.find(stem_of(view.image));
    if (found == by_name.end())
      throw Error(fmt::format("{}: has no pose of the picture {}", robot, view.image));
    view.base_from_hand = poses.base_from_hand[found->second];
    if (!poses.rotations.empty()) view.rotation_numbers = poses.rotations[found->second];
  }
}

}  // namespace tagcal::tools
