#include "commands/rig_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <ranges>

#include "commands/calibrate_many.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "job/shutter.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/rig_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/scene/rig_pairing.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// ms, of time:find: half of the longest time between instants that is interpolated.
constexpr const char* kFindTolerance = "50";

// The input of one camera: a folder of pictures, or a data set; with observations or without.
Input camera_input(const RigInputArguments& arguments, std::size_t camera, Exclusion& exclusion) {
  InputArguments input = arguments.input;
  if (!arguments.targets.empty()) input.target = arguments.targets.front();
  input.inputs = {arguments.input.inputs[camera]};
  if (!arguments.corners.empty()) input.observations = arguments.corners[camera];
  if (input.default_frames.empty()) input.default_frames = "evenly";  // equal in all
  if (input.frames == "auto") input.frames = input.default_frames;
  Input read = read_input(input, &exclusion);
  for (std::size_t b = 1; b < arguments.targets.size(); ++b)
    read.dataset.boards.push_back({read_target(arguments.targets[b], {}, &read.warnings), Pose()});
  return read;
}

void check_folders(const std::vector<std::string>& folders) {
  if (folders.size() < 2)
    throw Error(
        fmt::format("{}: is one camera: a rig needs the folders (or films) of two cameras or more, "
                    "or a data set with the key rig",
                    folders.front()));
  std::vector<fs::path> seen;
  for (const std::string& folder : folders) {
    std::error_code error;
    const fs::path path = fs::weakly_canonical(folder, error);
    if (std::ranges::find(seen, path) != seen.end())
      throw Error(folder + ": is given twice: each camera needs a folder of its own");
    seen.push_back(path);
  }
}

// The times of frames of videos or bags, if all views are such. Videos that begin at the same time
// follow one another.
void set_times(const Input& input, RigCamera& camera) {
  camera.times_s.clear();
  for (const View& view : camera.data.views) {
    const auto time = time_of(input, view.image);
    if (!time) return camera.times_s.clear();
    camera.times_s.push_back(*time);
  }
  if (!std::ranges::is_sorted(camera.times_s))
    camera.times_s = film_times(camera.data.views, input.times_s);
}

void check_outputs(const RigInputArguments& arguments, const std::vector<fs::path>& inputs) {
  const std::vector<std::string>& outputs = arguments.input.other_outputs;
  check_replaces_nothing({outputs.begin(), outputs.end()}, inputs);
}

std::vector<Instant> paired(const RigInputArguments& arguments,
                            const std::vector<RigCamera>& cameras) {
  const std::string& pair = arguments.pair;
  if (pair == "name") return pair_by_name(cameras);
  if (pair == "index") return pair_by_index(cameras);
  if (pair.starts_with("time:")) {
    std::string number = pair.substr(5);
    if (number.ends_with("ms")) number.resize(number.size() - 2);
    if (number == "find") number = kFindTolerance;
    const double tolerance_ms = number_of<double>(number).value_or(0);
    if (!(tolerance_ms > 0))
      throw Error("--pair: must be time:find, or time:5ms or another number of milliseconds, got " +
                  pair);
    return pair_by_time(cameras, tolerance_ms / 1e3);
  }
  check_outputs(arguments, {pair});
  std::vector<std::string> notes;
  std::vector<Instant> instants = pair_by_file(pair, cameras, &notes);
  print_warnings(notes);
  return instants;
}

std::vector<fs::path> files_of(const RigFolder& folder) {
  std::vector<fs::path> all = folder.texts;
  for (const RigCameraFiles& files : folder.files)
    all.insert(all.end(), files.images.begin(), files.images.end());
  return all;
}

void check_number_of_corners(const RigInputArguments& arguments, std::size_t num_cameras) {
  if (!arguments.corners.empty() && arguments.corners.size() != num_cameras)
    throw Error(fmt::format("--observations: needs a file for each of the {} cameras, got {}",
                            num_cameras, arguments.corners.size()));
}

// --observations instead of what the data set has, without the views of --exclude.
void choose_observations(const RigInputArguments& arguments, Exclusion& exclusion,
                         RigFolder& folder) {
  check_number_of_corners(arguments, folder.files.size());
  if (arguments.corners.empty() && arguments.input.excluded.empty()) return;
  for (std::size_t c = 0; c < folder.files.size(); ++c) {
    RigCamera& camera = folder.rig.cameras[c];
    RigCameraFiles& files = folder.files[c];
    if (!arguments.corners.empty()) {
      files.observations = arguments.corners[c];
      folder.texts.push_back(files.observations);
      camera.data.views =
          read_observations(files.observations, camera.data.boards, &folder.warnings);
    }
    std::erase_if(camera.data.views,
                  [&](const View& view) { return exclusion.excludes(view.image); });
    if (files.images.empty() && files.unreadable.empty() && camera.data.views.empty())
      throw Error("--exclude: leaves no picture of " + camera.name);
    if (!files.times_s.empty()) camera.times_s = times_of(camera.data.views, files);
  }
  folder.rig.instants.clear();
}

// Finds the corners of a camera, unless they are observations.
Input views_of_camera(const RigInputArguments& arguments, const RigCameraFiles& files,
                      RigCamera& camera) {
  Input read = input_of(camera.name, camera.data, files.images);
  read.observations = files.observations.string();
  read.of_dataset = arguments.corners.empty();
  read.strict = arguments.input.strict;
  read.refinement = refinement_of(arguments.input);
  leave_out(files.unreadable, read.strict, files.images.empty(), read.warnings);
  find_views(read, arguments.threads);
  print_warnings(read.warnings);
  camera.data.views = std::move(read.dataset.views);
  if (files.observations.empty() && !files.times_s.empty())
    camera.times_s = times_of(camera.data.views, files);
  return read;
}

// The files of a camera's pictures, and what they show of a wrong target.
void take_pictures(Input input, RigInput& result) {
  result.pictures.push_back(std::move(input.files));
  result.mistakes.insert(result.mistakes.end(), input.mistakes.begin(), input.mistakes.end());
}

// A data set with the key rig.
RigInput read_data_set(const RigInputArguments& arguments) {
  const std::string& name = arguments.input.inputs.front();
  if (!arguments.targets.empty())
    throw Error(fmt::format("--target: {} is a data set, which names its own boards", name));
  check_dataset_options(arguments.input);
  Exclusion exclusion(arguments.input.excluded);
  RigFolder folder =
      read_rig_folder(name, [&](const fs::path& file) { return exclusion.excludes(file); });
  choose_observations(arguments, exclusion, folder);
  warn_of_unused(exclusion, folder.warnings);
  check_outputs(arguments, files_of(folder));
  print_warnings(folder.warnings);
  RigInput result;
  for (std::size_t c = 0; c < folder.rig.cameras.size(); ++c)
    take_pictures(views_of_camera(arguments, folder.files[c], folder.rig.cameras[c]), result);
  if (folder.rig.instants.empty() || arguments.pair != "name")
    folder.rig.instants = paired(arguments, folder.rig.cameras);
  result.rig = std::move(folder.rig);
  return result;
}

}  // namespace

std::vector<std::string> camera_names(const std::vector<std::string>& inputs) {
  std::vector<fs::path> paths;
  for (const std::string& input : inputs) paths.push_back(folder_path(input));
  const auto equal = [&] {
    return std::ranges::all_of(paths, [&](const fs::path& path) {
      return path.has_relative_path() && path.filename() == paths.front().filename();
    });
  };
  while (equal())
    for (fs::path& path : paths) path = path.parent_path();
  std::vector<std::string> names;
  for (const fs::path& path : paths) {
    const std::string name = path.filename().string();
    const std::size_t open = name.find_first_of("*?[");
    names.push_back(open == std::string::npos || open == 0 ? name : name.substr(0, open));
  }
  return names;
}

std::vector<std::string> names_of_folders(const std::vector<std::string>& inputs) {
  check_folders(inputs);
  return camera_names(inputs);
}

RigInputArguments rig_arguments(const InputArguments& input, const std::string& pair, int threads) {
  RigInputArguments rig{input, {}, {}, pair, threads};
  for (const auto part : std::views::split(input.observations, ','))
    rig.corners.emplace_back(trimmed({part.begin(), part.end()}));
  if (!input.target.empty()) rig.targets = {input.target};
  return rig;
}

CameraViews read_camera_views(const InputArguments& input, const std::string& camera,
                              const std::string& pair, int threads) {
  if (pair != "name") throw Error("--pair: needs the file of a rig");
  CameraViews read{read_input(input), read_camera(camera)};
  check_image_size(read.camera.camera.image_size, camera, read.input);
  find_views(read.input, threads, true, &read.camera.camera);
  print_warnings(read.input.warnings);
  return read;
}

RigInput read_rig(const RigInputArguments& arguments) {
  const std::vector<std::string>& inputs = arguments.input.inputs;
  if (inputs.size() == 1 && is_rig_folder(inputs.front())) return read_data_set(arguments);
  const std::vector<std::string> names = names_of_folders(inputs);
  check_number_of_corners(arguments, inputs.size());
  Exclusion exclusion(arguments.input.excluded);
  std::vector<Input> read;
  for (std::size_t c = 0; c < inputs.size(); ++c)
    read.push_back(camera_input(arguments, c, exclusion));
  warn_of_unused(exclusion, read.front().warnings);
  RigInput result;
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    Input& input = read[c];
    find_views(input, arguments.threads);
    print_warnings(input.warnings);
    if (num_corners(input.dataset.views) == 0)
      throw Error(inputs[c] + ": no picture shows the board; see tagcal detect --explain");
    result.rig.cameras.push_back({names[c], std::move(input.dataset), {}});
    set_times(input, result.rig.cameras.back());
    result.refinement = input.refinement;
    take_pictures(std::move(input), result);
  }
  result.rig.instants = paired(arguments, result.rig.cameras);
  return result;
}

std::optional<RigInput> with_neighbours(const RigInput& rig, const RigInputArguments& arguments) {
  RigInput all = rig;
  bool has_more = false;
  for (std::size_t c = 0; c < rig.pictures.size(); ++c) {
    RigCamera& camera = all.rig.cameras[c];
    Input frames;
    frames.name = frames.sized_by = camera.name;
    frames.dataset = camera.data;
    frames.files = rig.pictures[c];
    frames.strict = arguments.input.strict;
    frames.refinement = rig.refinement;
    std::optional<Input> near = with_neighbours(frames, arguments.threads, true);
    if (!near) continue;
    has_more = true;
    std::map<fs::path, std::size_t> places;
    for (std::size_t v = 0; v < near->dataset.views.size(); ++v)
      places[near->files.at(near->dataset.views[v].image)] = v;
    for (Instant& instant : all.rig.instants)
      if (auto& view = instant.view[c])
        view = places.at(rig.pictures[c].at(camera.data.views[*view].image));
    camera.data.views = std::move(near->dataset.views);
    set_times(*near, camera);
    all.pictures[c] = std::move(near->files);
  }
  return has_more ? std::optional(std::move(all)) : std::nullopt;
}

Option add_pair(CLI::App& command, std::string& pair, const std::string& more) {
  return add_option(command, "--pair", pair,
                    "which pictures belong together: name (equal names, but for the camera's own "
                    "part), index, time:5ms (by stamps of data sets or videos)" +
                        more + ", or a table of pictures")
      .text("name|index|time:Tms|FILE");
}

}  // namespace tagcal::tools
