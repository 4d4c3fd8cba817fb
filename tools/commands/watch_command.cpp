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
#include "job/arguments.hpp"
#include "job/find_corners.hpp"
#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "watch/watch_session.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string folder;
  std::string target;
  double tag_size_m = 0;
  std::string out;
  std::string until;
  std::string model;
  double timeout_s = 0;
  double every_s = 0.5;
  bool no_cache = false;
  bool json = false;
  int threads = 0;
};

// "0.1px", "0.1 px" or "0.1"; 0: no goal.
double goal_of(const std::string& text) {
  if (text.empty()) return 0;
  double value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  const std::string_view unit = trimmed({end, last});
  if (error != std::errc() || !(unit == "px" || unit.empty()) || !(value > 0) ||
      !std::isfinite(value))
    throw Error(fmt::format("--until: must be a length in pixels, such as 0.1px, got {}", text));
  return value;
}

// "FOLDER.camera.yaml", beside the folder.
fs::path default_out(const fs::path& folder) {
  std::error_code error;
  fs::path whole = fs::weakly_canonical(fs::absolute(folder), error);
  if (!whole.has_filename()) whole = whole.parent_path();
  if (error || !whole.has_filename())
    throw Error(
        fmt::format("{}: has no name: give the calibration's file with --out", folder.string()));
  fs::path out = folder.has_filename() ? folder : folder.parent_path();
  if (out.empty() || out.filename() == "." || out.filename() == "..") out = whole;
  return out += ".camera.yaml";
}

void check_folder(const fs::path& folder) {
  if (!fs::exists(folder)) throw Error(fmt::format("{}: no such folder", folder.string()));
  if (!fs::is_directory(folder))
    throw Error(fmt::format("{}: must be a folder, got a file", folder.string()));
  if (list_pictures(folder).empty() && fs::exists(folder / "dataset.yaml"))
    throw Error(fmt::format("{}: is a data set: name the folder of its pictures", folder.string()));
}

Board target_of(const Arguments& arguments, std::vector<std::string>& warnings) {
  std::optional<double> size;
  if (arguments.tag_size_m > 0) size = arguments.tag_size_m;
  Board board = read_target(arguments.target, {}, &warnings, size);
  check_detectable({{board, {}}}, arguments.target);
  return board;
}

int run(const Arguments& arguments) {
  WatchOptions options;
  options.folder = arguments.folder;
  options.goal_px = goal_of(arguments.until);
  options.timeout_s = arguments.timeout_s;
  options.json = arguments.json;
  constexpr double kDay_s = 86400;  // longer pauses are shortened to it
  options.every = std::chrono::milliseconds(
      std::max(1L, std::lround(1000 * std::min(kDay_s, arguments.every_s))));
  options.calibration.model = arguments.model;
  options.calibration.num_threads = static_cast<std::size_t>(arguments.threads);
  if (arguments.model == "weak") throw Error("--model: weak has no lens to watch");
  naming_options([&] { check_options(options.calibration); });
  check_folder(options.folder);
  options.out = arguments.out.empty() ? default_out(options.folder) : fs::path(arguments.out);
  check_text_writable(options.out);
  check_replaces_nothing({options.out}, {arguments.target});
  std::vector<std::string> warnings;
  Board board = target_of(arguments, warnings);
  WatchedPictures pictures(
      options.folder, std::move(board),
      {arguments.threads, arguments.no_cache ? fs::path() : corner_cache_of(options.out),
       Interruption::requested});
  return WatchSession(std::move(options), pictures, std::move(warnings)).run();
}

}  // namespace

Command add_watch(CLI::App& app) {
  CLI::App* command =
      add_command(app, "watch", "calibrate while pictures are being taken: what to show next");
  const auto arguments = std::make_shared<Arguments>();
  add_option(*command, "FOLDER", arguments->folder, "the folder into which the pictures come")
      .required();
  add_option(*command, "--target", arguments->target, "the board in the pictures: a target file")
      .text("T.yaml")
      .required();
  add_length(*command, "--tag-size", arguments->tag_size_m,
             "side of the tags in metres, if --target is a field layout of WPILib (0.1651)")
      .seldom();
  add_option(*command, "--out", arguments->out,
             "file for the camera, written whole after each picture that leaves an answer; "
             "default: FOLDER.camera.yaml, beside the folder")
      .text("FILE");
  add_option(*command, "--until", arguments->until,
             "end once the largest standard deviation of the projection at infinity over the image "
             "is at most this (0.1px), with corners in all parts of the image and 6 pictures")
      .text("Xpx");
  std::vector<std::string> models = model_names();
  models.insert(models.begin(), "auto");
  add_option(*command, "--model", arguments->model, fmt::format("{}", fmt::join(models, ", ")))
      .one_of(models)
      .text("M");
  add_positive(*command, "--timeout", arguments->timeout_s,
               "end after this many seconds without a new picture; default: never");
  add_positive(*command, "--every", arguments->every_s,
               "seconds between two looks at the folder (0.5)")
      .seldom();
  add_flag(*command, "--json", arguments->json,
           "at the end one JSON object on stdout, as of tagcal calibrate; all else on stderr");
  add_no_cache(*command, arguments->no_cache);
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal watch photos --target board.yaml --until 0.1px\n"
             "         tagcal watch photos --target board.yaml --out c.yaml --timeout 120\n"
             "Exit codes: 0 a calibration (with --until: the goal is met),\n"
             "            1 the goal is not met, 2 bad input, 3 no calibration.");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
