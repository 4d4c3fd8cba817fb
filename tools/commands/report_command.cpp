#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/input.hpp"
#include "page_data/page_parts.hpp"
#include "page_data/pages.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

struct ReportArguments {
  std::string first;    // a calibration, or the poses of tagcal pose --json
  InputArguments data;  // .inputs: pictures with --target, else one other calibration at most
  std::string dataset;
  std::string camera;  // of poses
  double near_m = 0;   // of a comparison; 0: a metre
  std::string out = "report.html";
  int threads = 0;
};

bool has_data(const ReportArguments& arguments) {
  return !arguments.dataset.empty() || !arguments.data.target.empty();
}

void check_usage(const ReportArguments& arguments) {
  const InputArguments& data = arguments.data;
  if (!arguments.dataset.empty() && !data.target.empty())
    throw Error("--dataset, --target: give only one of the two");
  if (!data.target.empty() && data.inputs.empty())
    throw Error("--target: needs the pictures, after the calibration");
  if (data.target.empty() && data.inputs.size() > 1)
    throw Error(fmt::format("{}: two calibrations at most are compared (pictures need --target)",
                            data.inputs[1]));
  const bool has_options = data.tag_size_m > 0 || !data.refinement.empty() ||
                           !data.excluded.empty() || !data.frames.empty() || data.strict;
  if (has_options && !has_data(arguments))
    throw Error(
        "--tag-size, --refinement, --exclude, --frames, --strict: need --dataset or --target");
  if (!data.observations.empty() && arguments.dataset.empty())
    throw Error("--observations: needs --dataset");
  if (data.target.empty() && !data.inputs.empty() && !arguments.dataset.empty())
    throw Error(fmt::format("{}: a comparison of two calibrations takes no --dataset",
                            data.inputs.front()));
}

void check_out(const ReportArguments& arguments) {
  std::vector<std::string> inputs = arguments.data.inputs;
  inputs.insert(inputs.end(), {arguments.first, arguments.data.target, arguments.data.observations,
                               arguments.camera});
  check_page(arguments.out, inputs);
}

std::optional<Input> input_of(const ReportArguments& arguments) {
  if (!has_data(arguments)) return std::nullopt;
  InputArguments data = arguments.data;
  if (!arguments.dataset.empty()) data.inputs = {arguments.dataset};
  return read_input(data);
}

int run(const ReportArguments& arguments) {
  check_usage(arguments);
  check_out(arguments);
  const bool compares = arguments.data.target.empty() && !arguments.data.inputs.empty();
  const bool shows_poses = !compares && is_poses_file(arguments.first);
  if (!compares && arguments.near_m > 0)
    throw Error("--distance: needs two calibrations to compare");
  if (!shows_poses && !arguments.camera.empty())
    throw Error("--camera: only for the poses of tagcal pose --json");
  if (!arguments.camera.empty() && !has_data(arguments))
    throw Error("--camera: shows residuals, which need --dataset or --target");
  if (compares) {
    const double near_m = arguments.near_m > 0 ? arguments.near_m : 1;
    write_page(arguments.out,
               difference_page(arguments.first, arguments.data.inputs.front(), near_m));
    return kAnswer;
  }
  if (const auto rig = shows_poses ? std::nullopt : rig_in_file(arguments.first)) {
    if (has_data(arguments))
      throw Error(
          fmt::format("{0}: is a rig, whose page takes no data: tagcal rig --report shows "
                      "that of its pictures, and {0}:{1} is one camera",
                      arguments.first, rig->cameras.front().name));
    write_page(arguments.out, rig_page(*rig, arguments.first));
    return kAnswer;
  }
  std::optional<Input> input = input_of(arguments);
  Input* const given = input ? &*input : nullptr;
  if (shows_poses) {
    write_page(arguments.out,
               poses_page({arguments.first, arguments.camera, given, arguments.threads}));
    return kAnswer;
  }
  write_page(arguments.out,
             calibration_page(content_from_file(arguments.first, given, arguments.threads)));
  return kAnswer;
}

}  // namespace

Command add_report(CLI::App& app) {
  CLI::App* command =
      add_command(app, "report",
                  "a page to look at: a calibration, two compared, a rig, or the poses of views");
  const auto arguments = std::make_shared<ReportArguments>();
  add_option(
      *command, "CALIBRATION", arguments->first,
      "a file of a camera or a rig, of any format, or the poses that tagcal pose --json printed")
      .required();
  add_option(*command, "OTHER|IMAGE", arguments->data.inputs,
             "another calibration to compare with, or (with --target) the pictures");
  add_option(*command, "--dataset", arguments->dataset,
             "the data set whose corners, residuals and pictures are shown")
      .text("D");
  add_observations(*command, arguments->data);
  add_option(*command, "--target", arguments->data.target,
             "the board in the pictures, instead of a data set: a target file")
      .text("T.yaml");
  add_picture_options(*command, arguments->data);
  add_option(*command, "--camera", arguments->camera,
             "the camera of the poses, with which their residuals are shown")
      .text("CAMERA");
  add_length(*command, "--distance", arguments->near_m,
             "distance in metres at which two calibrations are compared, beside infinity (1)")
      .seldom();
  add_option(*command, "--out", arguments->out, "file of the page (report.html)")
      .text("FILE.html")
      .writes_text();
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal report camera.yaml --dataset desk --out report.html\n"
             "         tagcal report camera.yaml --target board.yaml photos/*.jpg\n"
             "         tagcal report monday.yaml friday.yaml --out difference.html\n"
             "         tagcal report poses.json --dataset desk --camera camera.yaml\n"
             "The page of a new calibration shows more: tagcal calibrate --report FILE.");
  return {command, [arguments] { return run(*arguments); }, true};
}

}  // namespace tagcal::tools
