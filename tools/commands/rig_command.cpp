#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "commands/rig_input.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/shutter.hpp"
#include "page_data/pages.hpp"
#include "report/rig_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct RigArguments : RigInputArguments {
  bool find_boards = false;
  std::string lenses = "joint";
  std::vector<std::string> cameras;  // NAME=FILE
  std::vector<std::string> models;   // M, or NAME=M
  std::string reference;
  std::string shutter;
  std::string out;
  std::string report;  // a page
  bool json = false;
};

// "NAME=VALUE": the index of the camera, and the value.
std::pair<std::size_t, std::string> camera_value(const RigDataset& rig, const std::string& text,
                                                 const std::string& option) {
  const std::size_t sign = text.find('=');
  const std::string name = text.substr(0, sign);
  const auto camera = std::ranges::find(rig.cameras, name, &RigCamera::name);
  if (sign == std::string::npos || camera == rig.cameras.end()) {
    std::string names;
    for (const RigCamera& c : rig.cameras) names += (names.empty() ? "" : ", ") + c.name;
    throw Error(
        fmt::format("{}: must be NAME=VALUE with a camera of {}, got {}", option, names, text));
  }
  return {static_cast<std::size_t>(camera - rig.cameras.begin()), text.substr(sign + 1)};
}

RigOptions rig_options(const RigArguments& arguments, const RigDataset& rig) {
  RigOptions options;
  options.calibrate.assign(rig.cameras.size(), {});
  for (CalibrateOptions& o : options.calibrate)
    o.num_threads = static_cast<std::size_t>(arguments.threads);
  for (const std::string& text : arguments.models) {
    if (text.find('=') == std::string::npos) {
      for (CalibrateOptions& o : options.calibrate) o.model = text;
      continue;
    }
    const auto [camera, model] = camera_value(rig, text, "--model");
    options.calibrate[camera].model = model;
  }
  for (const CalibrateOptions& o : options.calibrate) naming_options([&] { check_options(o); });
  options.find_boards = arguments.find_boards || arguments.targets.size() > 1;
  options.find_clocks = arguments.pair == "time:find";
  options.find_readouts = arguments.shutter == "rolling";
  options.lenses = arguments.lenses == "fixed" ? RigLenses::fixed : RigLenses::joint;
  if (arguments.lenses != "joint") {
    std::vector<std::optional<CalibrationFile>> files(rig.cameras.size());
    for (const std::string& text : arguments.cameras) {
      const auto [camera, file] = camera_value(rig, text, "--camera");
      files[camera] = read_camera(file);
    }
    for (std::size_t c = 0; c < files.size(); ++c) {
      if (!files[c])
        throw Error(fmt::format("--cameras {}: needs --camera {}=FILE", arguments.lenses,
                                rig.cameras[c].name));
      if (options.lenses == RigLenses::fixed)
        options.known.push_back(
            {uncertain_camera(*files[c]), files[c]->camera_error_px.value_or(0)});
      else
        options.calibrate[c].start = files[c]->camera;
    }
  } else if (!arguments.cameras.empty()) {
    throw Error("--camera: needs --cameras fixed or --cameras start");
  }
  if (!arguments.reference.empty())
    options.reference = camera_value(rig, arguments.reference + "=", "--reference").first;
  return options;
}

void check_ids(const RigDataset& rig, const std::vector<std::string>& targets) {
  std::map<CornerId, std::size_t> board_of;
  const std::vector<PlacedBoard>& boards = rig.cameras.front().data.boards;
  for (std::size_t b = 0; b < targets.size() && targets.size() > 1; ++b)
    for (const TargetPoint& p : target_points(boards[b].board))
      if (const auto [at, is_new] = board_of.emplace(p.id, b); !is_new)
        throw Error(fmt::format("{}: has the id {} of {}: the ids of boards must differ (first_id)",
                                targets[b], p.id.tag_id, targets[at->second]));
}

// Those of the arguments, before any work; read_rig checks the files that it finds.
void check_outputs(const RigArguments& arguments) {
  check_yaml_writable(arguments.out);
  std::vector<std::string> files = arguments.input.inputs;
  files.insert(files.end(), arguments.targets.begin(), arguments.targets.end());
  files.insert(files.end(), arguments.corners.begin(), arguments.corners.end());
  for (const std::string& camera : arguments.cameras)
    files.push_back(camera.substr(camera.find('=') + 1));
  check_replaces_nothing({arguments.out, arguments.report}, {files.begin(), files.end()});
  if (!arguments.report.empty()) check_page(arguments.report, files);
}

bool has_readout(const RigCalibration& rig) {
  return std::ranges::any_of(rig.cameras, [](const RigCameraEstimate& camera) {
    return camera.own.readout && camera.own.readout->is_seen;
  });
}

// Looks for the readouts of rolling shutters, as a calibration of one camera does.
RigCalibration calibrate_by_times(const RigArguments& arguments, RigOptions options,
                                  RigInput& input) {
  std::optional<RigInput> near = with_neighbours(input, arguments);
  options.find_readouts = true;
  RigCalibration timed = calibrate_rig(near ? near->rig : input.rig, options);
  if (has_readout(timed)) {
    if (near) input = *std::move(near);
    return timed;
  }
  options.find_readouts = false;
  if (near) return calibrate_rig(input.rig, options);
  for (RigCameraEstimate& camera : timed.cameras) forget_readout(camera.own);
  forget_readout(timed.findings);
  return timed;
}

RigCalibration calibrate_input(const RigArguments& arguments, Shutter shutter,
                               const RigOptions& options, RigInput& input) {
  const bool has_times =
      std::ranges::none_of(input.rig.cameras, &std::vector<double>::empty, &RigCamera::times_s);
  check_times(shutter, has_times);
  return shutter == Shutter::automatic && has_times ? calibrate_by_times(arguments, options, input)
                                                    : calibrate_rig(input.rig, options);
}

int run(const RigArguments& given) {
  RigArguments arguments = given;
  const Shutter shutter = shutter_of(arguments.shutter, arguments.input.default_frames);
  check_outputs(arguments);
  arguments.input.other_outputs = {arguments.out, arguments.report};
  RigInput input = read_rig(arguments);
  const RigDataset& rig = input.rig;
  check_different(rig);
  check_ids(rig, arguments.targets);
  const RigOptions options = rig_options(arguments, rig);
  RigCalibration answer = calibrate_input(arguments, shutter, options, input);
  refuse(wrong_target(input.mistakes), answer);
  const bool answered = is_answer(answer.status);
  if (answered) write_answer_file(arguments.out, rig_yaml(answer));
  if (!arguments.report.empty())
    write_page(arguments.report, rig_page(rig, answer, options, input.pictures));
  print_answer(arguments.json ? rig_json(rig, answer, options.reference)
                              : rig_summary(answer, options.reference),
               arguments.json, answered ? arguments.out : "");
  if (!answered) say_no_answer_file(arguments.out);
  return answered ? kAnswer : kNoAnswer;
}

// Cameras, boards, corners and instants.
void add_data(CLI::App& command, RigArguments& arguments) {
  add_option(command, "FOLDER", arguments.input.inputs,
             "a data set with the key rig, or for each camera a folder of pictures, a pattern "
             "('left*.png') or a data set")
      .required();
  add_option(command, "--target", arguments.targets,
             "a board in the pictures: a target file. Of several, the places in one another are "
             "estimated")
      .text("T.yaml")
      .repeatable();
  add_picture_options(command, arguments.input);
  add_flag(command, "--find-boards", arguments.find_boards,
           "the boards of the data set stand still, but not at the places that it says: estimate "
           "these")
      .seldom();
  add_option(command, "--observations", arguments.corners,
             "files with the corners of each camera, in the order of the folders")
      .separated_by(',')
      .reads_text()
      .text("CSV,CSV");
  add_no_cache(command, arguments.input.no_cache);
  add_shutter(command, arguments.shutter);
  add_pair(command, arguments.pair,
           ", time:find (the same, and each picture is moved to the time of its instant, with one "
           "offset a camera)")
      .text("name|index|time:Tms|time:find|FILE");
}

void add_lenses_and_outputs(CLI::App& command, RigArguments& arguments) {
  add_option(command, "--cameras", arguments.lenses,
             "joint: lenses are estimated with the extrinsics; fixed: as --camera says, with its "
             "standard deviations; start: estimated from there")
      .one_of({"joint", "fixed", "start"})
      .text("HOW");
  add_option(command, "--camera", arguments.cameras,
             "a camera's file of any format, for --cameras fixed or start")
      .text("NAME=FILE")
      .repeatable();
  add_option(
      command, "--model", arguments.models,
      fmt::format("model of all cameras, or of one: auto, {}", fmt::join(model_names(), ", ")))
      .suggests(model_names())
      .text("M|NAME=M")
      .repeatable();
  add_option(command, "--reference", arguments.reference,
             "the camera whose frame is that of the rig; default: the first")
      .seldom()
      .text("NAME");
  add_option(command, "--out", arguments.out, "file for the rig, written if there is an answer")
      .text("FILE")
      .writes_text();
  add_option(command, "--report", arguments.report,
             "a page: the rig in 3D, pairs, lenses (report.md)")
      .text("FILE.html");
  add_flag(command, "--json", arguments.json, "one JSON object on stdout");
  add_threads(command, arguments.threads);
}

}  // namespace

Command add_rig(CLI::App& app) {
  CLI::App* command =
      add_command(app, "rig", "several cameras on one body: their lenses and where they are");
  const auto arguments = std::make_shared<RigArguments>();
  add_data(*command, *arguments);
  add_lenses_and_outputs(*command, *arguments);
  add_footer(*command, "Example: tagcal rig left right --target board.yaml --out rig.yaml");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
