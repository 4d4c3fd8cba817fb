#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.hpp"
#include "commands/rig_poses.hpp"
#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "report/check_report.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {
namespace {

struct CheckArguments {
  InputArguments input;
  std::string camera;
  std::string pair = "name";
  CheckOptions options;
  int threads = 0;
  bool json = false;
};

CameraCheck check_of_rig(const CheckArguments& arguments) {
  const RigInputArguments rig = rig_arguments(arguments.input, arguments.pair, arguments.threads);
  const CameraFile file = read_camera_file(arguments.camera);
  check_folders_of_rig(rig, file, arguments.camera);
  const RigDataset data = read_rig(rig).rig;
  const KnownRig known = rig_of(data, file, arguments.camera);
  return naming(arguments.camera, [&] { return check_rig(data, known, arguments.options); });
}

// Corners at wrong places of the board test no camera.
void refuse_wrong_target(const std::vector<TargetMistake>& mistakes, CameraCheck& check) {
  const auto mistake = std::ranges::find_if(mistakes, &TargetMistake::moves_corners);
  if (mistake == mistakes.end()) return;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  check.verdict = CheckVerdict::cannot_tell;
  check.in_sigmas = -kInfinite;
  check.smallest_px = kInfinite;
  check.change.reset();
  check.detectable.clear();
  add(check.findings, code::no_consensus,
      "the pictures and the target file do not agree: " + mistake->text());
}

CameraCheck check_of_camera(const CheckArguments& arguments) {
  const CameraViews read =
      read_camera_views(arguments.input, arguments.camera, arguments.pair, arguments.threads);
  CameraCheck check = naming(arguments.camera, [&] {
    return check_camera(read.input.dataset, uncertain_camera(read.camera), arguments.options);
  });
  refuse_wrong_target(read.input.mistakes, check);
  return check;
}

int run(const CheckArguments& arguments) {
  const CameraCheck check =
      is_rig_file(arguments.camera) ? check_of_rig(arguments) : check_of_camera(arguments);
  print_answer(arguments.json ? json_text(check_json(check))
                              : check_text(check, arguments.camera, arguments.options.limit_px),
               arguments.json);
  if (check.verdict == CheckVerdict::cannot_tell) return kNoAnswer;
  return check.verdict == CheckVerdict::valid ? kAnswer : kCheckFailed;
}

}  // namespace

Command add_check(CLI::App& app) {
  CLI::App* command = add_command(
      app, "check", "if a calibration is still valid: new pictures against a camera or a rig");
  const auto arguments = std::make_shared<CheckArguments>();
  add_input(*command, arguments->input);
  add_observations(*command, arguments->input);
  add_option(
      *command, "--camera", arguments->camera,
      "the camera's file, of any format (tagcal convert), or a rig's: then a folder a camera")
      .text("CAMERA")
      .required();
  add_pair(*command, arguments->pair).seldom();
  add_positive(*command, "--limit", arguments->options.limit_px,
               "the change that matters, px in the image (1): valid only if a smaller one would "
               "have shown");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Exit code: 0 valid, 1 changed, 3 cannot tell\n"
             "Example: tagcal check --target board.yaml new_photos --camera camera.yaml\n"
             "         tagcal check today --camera camera.yaml --limit 0.3\n"
             "         tagcal check --target board.yaml left right --camera rig.yaml");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
