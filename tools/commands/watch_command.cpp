#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "commands/rig_input.hpp"
#include "job/arguments.hpp"
#include "job/find_corners.hpp"
#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "watch/live_frames.hpp"
#include "watch/sessions.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct WatchArguments {
  std::vector<std::string> folders;
  bool rig = false;
  std::string target;
  double tag_size_m = 0;
  std::string out;
  std::string keep;  // of the frames of a video; "": a temporary folder
  std::string until;
  std::string model;
  double timeout_s = 0;
  double every_s = 0.5;
  bool no_cache = false;
  bool json = false;
  int threads = 0;
};

// Beside the folder: "FOLDER.camera.yaml" for an ending, or a file of this name.
fs::path default_out(const fs::path& folder, const std::string& name) {
  std::error_code error;
  fs::path whole = fs::weakly_canonical(fs::absolute(folder), error);
  if (!whole.has_filename()) whole = whole.parent_path();
  if (error || !whole.has_filename())
    throw Error(
        fmt::format("{}: has no name: give the calibration's file with --out", folder.string()));
  fs::path out = folder.has_filename() ? folder : folder.parent_path();
  if (out.empty() || out.filename() == "." || out.filename() == "..") out = whole;
  return name.starts_with('.') ? out += name : out.replace_filename(name);
}

void check_folder(const fs::path& folder) {
  if (!fs::exists(folder)) throw Error(fmt::format("{}: no such folder", folder.string()));
  if (!fs::is_directory(folder))
    throw Error(fmt::format("{}: must be a folder, got a file", folder.string()));
  if (list_pictures(folder).empty() && fs::exists(folder / "dataset.yaml"))
    throw Error(fmt::format("{}: is a data set; give its image folder", folder.string()));
}

struct Target {
  Board board;
  std::vector<std::string> warnings;
};

Target target_of(const WatchArguments& arguments) {
  std::optional<double> size;
  if (arguments.tag_size_m > 0) size = arguments.tag_size_m;
  Target target;
  target.board = read_target(arguments.target, {}, &target.warnings, size);
  check_detectable({{target.board, {}}}, arguments.target);
  return target;
}

WatchSettings settings_of(const WatchArguments& arguments) {
  constexpr double kDay_s = 86400;  // longer pauses are shortened to it
  const std::chrono::milliseconds every(
      std::max(1L, std::lround(1000 * std::min(kDay_s, arguments.every_s))));
  return {{}, goal_of(arguments.until), arguments.json, arguments.timeout_s, every};
}

CalibrateOptions calibrate_options(const WatchArguments& arguments) {
  CalibrateOptions options;
  options.model = arguments.model;
  options.num_threads = static_cast<std::size_t>(arguments.threads);
  if (arguments.model == "weak") throw Error("--model: weak has no lens to watch");
  naming_options([&] { check_options(options); });
  return options;
}

// The cache of the corners of each camera stands beside the rig's file.
fs::path cache_of(const WatchArguments& arguments, const fs::path& out) {
  return arguments.no_cache ? fs::path() : corner_cache_of(out);
}

int run_rig(const WatchArguments& arguments) {
  RigWatchOptions options{settings_of(arguments), {}};
  options.calibration.calibrate = {calibrate_options(arguments)};
  const std::vector<std::string> names = names_of_folders(arguments.folders);
  for (const std::string& folder : arguments.folders) check_folder(folder);
  options.out = arguments.out.empty() ? default_out(arguments.folders.front(), "rig.yaml")
                                      : fs::path(arguments.out);
  check_yaml_writable(options.out);
  check_replaces_nothing({options.out}, {arguments.target});
  Target target = target_of(arguments);
  std::vector<WatchedCamera> cameras;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const fs::path folder = arguments.folders[c];
    const fs::path cache = cache_of(arguments, fs::path(options.out) += "." + names[c]);
    cameras.push_back(
        {names[c], folder,
         std::make_unique<WatchedPictures>(
             folder, target.board,
             WatchedPictures::Options{arguments.threads, cache, Interruption::requested})});
  }
  return watch_rig(std::move(options), std::move(cameras), std::move(target.warnings));
}

int watch(const WatchArguments& arguments, WatchOptions options, Target target,
          const fs::path& cache) {
  check_yaml_writable(options.out);
  check_replaces_nothing({options.out}, {arguments.target});
  WatchedPictures pictures(options.folder, std::move(target.board),
                           {arguments.threads, cache, Interruption::requested});
  return watch_folder(std::move(options), pictures, std::move(target.warnings));
}

// A live video on stdin.
int run_live(const WatchArguments& arguments) {
  Target target = target_of(arguments);  // its errors come before a folder is made
  const CalibrateOptions calibration = calibrate_options(arguments);
  WatchSettings settings = settings_of(arguments);
  settings.out = arguments.out.empty() ? "camera.yaml" : arguments.out;
  const LiveFrames frames(arguments.keep);
  const auto has_ended = [&frames](std::string& why) {
    why = frames.problem();
    return frames.has_ended();
  };
  return watch(arguments, {settings, frames.folder(), "the video on stdin", calibration, has_ended},
               std::move(target), {});
}

int run(const WatchArguments& arguments) {
  const std::string& folder = arguments.folders.front();
  if (!arguments.keep.empty() && (arguments.rig || folder != "-"))
    throw Error("--keep: needs a video on stdin (-)");
  if (arguments.rig) return run_rig(arguments);
  if (arguments.folders.size() > 1)
    throw Error("watch: takes one folder; those of several cameras on one body need --rig");
  if (folder == "-") return run_live(arguments);
  WatchOptions options{settings_of(arguments), folder, folder, calibrate_options(arguments), {}};
  check_folder(folder);
  options.out =
      arguments.out.empty() ? default_out(options.folder, ".camera.yaml") : fs::path(arguments.out);
  const fs::path cache = cache_of(arguments, options.out);
  return watch(arguments, std::move(options), target_of(arguments), cache);
}

// The calibration, and when it ends.
void add_calibration(CLI::App& command, WatchArguments& arguments) {
  add_option(command, "--out", arguments.out,
             "file for the camera, written whole after each picture that leaves an answer; "
             "default: FOLDER.camera.yaml, of a rig rig.yaml, beside the folder; "
             "of a video camera.yaml")
      .text("FILE");
  add_option(command, "--keep", arguments.keep,
             "a new folder for the frames of the video that are used; default: they are not kept")
      .seldom()
      .text("DIR");
  add_option(command, "--until", arguments.until,
             "end once the largest standard deviation of the projection at infinity over the image "
             "is at most this (0.1px), with corners in all parts of the image and 6 pictures")
      .text("Xpx");
  std::vector<std::string> models = model_names();
  models.insert(models.begin(), "auto");
  add_option(command, "--model", arguments.model, fmt::format("{}", fmt::join(models, ", ")))
      .one_of(models)
      .text("M");
  add_positive(command, "--timeout", arguments.timeout_s,
               "end after this many seconds without a new picture; default: never");
  add_positive(command, "--every", arguments.every_s,
               "seconds between two looks at the folder (0.5)")
      .seldom();
}

}  // namespace

Command add_watch(CLI::App& app) {
  CLI::App* command =
      add_command(app, "watch", "calibrate while pictures are being taken: what to show next");
  const auto arguments = std::make_shared<WatchArguments>();
  add_option(*command, "FOLDER", arguments->folders,
             "the folder into which the pictures come, or - for the video of a camera on stdin "
             "(MJPEG, Y4M); "
             "with --rig a folder for each camera")
      .required();
  add_flag(*command, "--rig", arguments->rig,
           "several cameras on one body: which pair needs the board next");
  add_option(*command, "--target", arguments->target, "the board in the pictures: a target file")
      .text("T.yaml")
      .required();
  add_length(*command, "--tag-size", arguments->tag_size_m,
             "side of the tags in metres, if --target is a field layout of WPILib (0.1651)")
      .seldom();
  add_calibration(*command, *arguments);
  add_flag(*command, "--json", arguments->json,
           "at the end one JSON object on stdout, as of tagcal calibrate; all else on stderr");
  add_no_cache(*command, arguments->no_cache);
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal watch photos --target board.yaml --until 0.1px\n"
             "         tagcal watch photos --target board.yaml --out c.yaml --timeout 120\n"
             "         ffmpeg .. -f mjpeg - | tagcal watch - --target board.yaml\n"
             "         tagcal watch left right --target board.yaml --until 0.1px --rig\n"
             "Exit codes: 0 a calibration (with --until: the goal is met),\n"
             "            1 the goal is not met, 2 bad input, 3 no calibration.");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
