#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "commands/commands.hpp"
#include "commands/rig_poses.hpp"
#include "job/arguments.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "job/terminal.hpp"
#include "report/findings.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {
namespace {

using CheckJson = nlohmann::ordered_json;

// A parameter as people read it: a place in degrees and mm.
struct ShownChange {
  std::string name;
  double factor = 1;
  const char* unit = "";
};

ShownChange shown_as(const CameraChange& change, const ParameterChange& parameter) {
  const std::string axis = parameter.name.substr(parameter.name.size() - 1);
  if (change.kind == ChangeKind::place && parameter.name.starts_with("r"))
    return {"turned about " + axis, internal::degrees(1), " deg"};
  if (change.kind == ChangeKind::place) return {"moved along " + axis, 1e3, " mm"};
  const bool is_pixel = parameter.name.starts_with("f") || parameter.name.starts_with("c");
  return {parameter.name, 1, is_pixel ? " px" : ""};
}

std::string parameter_lines(const CameraChange& change) {
  std::string text;
  for (const ParameterChange& parameter : change.parameters) {
    const ShownChange shown = shown_as(change, parameter);
    const Measured m = measured(shown.factor * parameter.change, shown.factor * parameter.sigma);
    const char* const sign = parameter.change > 0 ? "+" : "";
    text += fmt::format("  {:<16} {}{} +- {}{}", shown.name, sign, m.value,
                        m.sigma.empty() ? "0" : m.sigma, shown.unit);
    if (change.kind != ChangeKind::place)
      text += fmt::format(", from {}", measured(parameter.known, parameter.sigma).value);
    text += "\n";
  }
  return text;
}

std::string size_text(const DetectableChange& change) {
  if (change.size == 0 || !std::isfinite(change.max_px)) return "";
  return fmt::format(" ({} {})", two_digits(change.size),
                     change.kind == ChangeKind::place ? "mm" : "px of the parameter");
}

std::string pixels_text(double px) {
  return std::isfinite(px) && px < 1e4 ? two_digits(px) + " px" : "any number of pixels";
}

// "the focal length of left": a kind of change, with the camera of several.
std::string changed_part(const CameraCheck& check, std::size_t camera, ChangeKind kind) {
  const std::string name(kind_name(kind));
  return check.cameras.size() > 1 ? name + " of " + check.cameras[camera].name : name;
}

std::string detectable_lines(const CameraCheck& check) {
  if (check.detectable.empty()) return "";
  std::string text = fmt::format("these pictures would show, {:.0f} times of 100, a change of\n",
                                 100 * check.power);
  for (const DetectableChange& change : check.detectable)
    text +=
        fmt::format("  {:<34} {} in the image{}\n", changed_part(check, change.camera, change.kind),
                    pixels_text(change.max_px), size_text(change));
  return text;
}

std::string camera_lines(const CameraCheck& check) {
  std::string text;
  for (const CheckedCamera& camera : check.cameras)
    text += fmt::format(
        "{}{}, {}, noise {} px; rms {:.4f} px by the file, {:.4f} px by a free camera\n",
        check.cameras.size() > 1 ? camera.name + ": " : "",
        counted(static_cast<std::size_t>(camera.num_views), "picture"),
        counted(static_cast<std::size_t>(camera.num_corners), "corner"),
        two_digits(camera.sigma_px), camera.known_rms_px, camera.rms_px);
  return text;
}

// "; a change of the principal point would explain these pictures as well: take more to tell"
std::string others_text(const CameraCheck& check) {
  std::vector<std::string> others;
  for (const ChangedPart& other : check.change->as_well)
    others.push_back(changed_part(check, other.camera, other.kind));
  if (others.empty()) return "";
  return fmt::format("; a change of the {} would explain these pictures as well: take more to tell",
                     fmt::join(others, " or the "));
}

std::string sentence(const CameraCheck& check, const std::string& file, double limit_px) {
  const std::string score = std::isfinite(check.in_sigmas)
                                ? fmt::format(
                                      " (score {:.1f}; {:.0f} false alarm in 100 checks if "
                                      "lens and board are as modelled)",
                                      check.in_sigmas, 100 * check.false_alarm)
                                : "";
  switch (check.verdict) {
    case CheckVerdict::valid:
      return "the pictures agree with " + file + score;
    case CheckVerdict::changed:
      if (!check.change)
        return "the pictures contradict " + file + ", and no single part of it explains them" +
               score;
      return fmt::format("the {} is no longer that of {}, by {} in the image at most{}{}",
                         changed_part(check, check.change->camera, check.change->kind), file,
                         pixels_text(check.change->max_px), score, others_text(check));
    case CheckVerdict::cannot_tell:
      break;
  }
  if (!std::isfinite(check.in_sigmas)) return "the pictures do not test " + file;
  return fmt::format("a change of {} in the image could be hidden in these pictures, and {} matter",
                     pixels_text(check.smallest_px), two_digits(limit_px) + " px");
}

std::string verdict_word(CheckVerdict verdict) {
  if (verdict == CheckVerdict::valid) return toned(Tone::good, "VALID");
  return verdict == CheckVerdict::changed ? toned(Tone::bad, "CHANGED")
                                          : toned(Tone::caution, "CANNOT TELL");
}

CheckJson number_json(double value) {
  return std::isfinite(value) ? CheckJson(value) : CheckJson();
}

CheckJson change_json(const CameraCheck& check, const CameraChange& change) {
  CheckJson parameters = CheckJson::array();
  for (const ParameterChange& p : change.parameters)
    parameters.push_back(
        {{"name", p.name}, {"known", p.known}, {"change", p.change}, {"sigma", p.sigma}});
  CheckJson as_well = CheckJson::array();
  for (const ChangedPart& other : change.as_well)
    as_well.push_back(
        {{"camera", check.cameras[other.camera].name}, {"kind", kind_name(other.kind)}});
  return {{"camera", check.cameras[change.camera].name},
          {"kind", kind_name(change.kind)},
          {"parameters", parameters},
          {"rms_px", change.rms_px},
          {"max_px", change.max_px},
          {"as_well", as_well}};
}

// What `tagcal check` says of the camera or rig in a file.
std::string check_text(const CameraCheck& check, const std::string& file, double limit_px) {
  std::string text =
      wrapped(verdict_word(check.verdict) + ": ", sentence(check, file, limit_px), 2);
  if (check.verdict == CheckVerdict::changed && check.change)
    text += parameter_lines(*check.change);
  return text + detectable_lines(check) + camera_lines(check) + findings_text(check.findings);
}

CheckJson check_json(const CameraCheck& check) {
  CheckJson detectable = CheckJson::array(), cameras = CheckJson::array();
  for (const DetectableChange& d : check.detectable)
    detectable.push_back({{"camera", check.cameras[d.camera].name},
                          {"kind", kind_name(d.kind)},
                          {"max_px", number_json(d.max_px)},
                          {"without_scale_px", number_json(d.without_scale_px)},
                          {"size", number_json(d.size)}});
  for (const CheckedCamera& c : check.cameras)
    cameras.push_back({{"name", c.name},
                       {"views", c.num_views},
                       {"corners", c.num_corners},
                       {"sigma_px", c.sigma_px},
                       {"rms_px", c.rms_px},
                       {"known_rms_px", c.known_rms_px}});
  return {{"verdict", verdict_name(check.verdict)},
          {"in_sigmas", number_json(check.in_sigmas)},
          {"false_alarm", check.false_alarm},
          {"power", check.power},
          {"change", check.change ? change_json(check, *check.change) : CheckJson()},
          {"smallest_px", number_json(check.smallest_px)},
          {"detectable", detectable},
          {"cameras", cameras},
          {"findings", findings_json(check.findings)}};
}

struct CheckArguments {
  InputArguments input;
  std::string camera;
  std::string pair = "name";
  CheckOptions options;
  int threads = 0;
  bool json = false;
};

// Corners at wrong places of the board test no camera.
void refuse_wrong_target(const std::vector<TargetMistake>& mistakes, CameraCheck& check) {
  const std::optional<Finding> wrong = wrong_target(mistakes);
  if (!wrong) return;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  check.verdict = CheckVerdict::cannot_tell;
  check.in_sigmas = -kInfinite;
  check.smallest_px = kInfinite;
  check.change.reset();
  check.detectable.clear();
  check.findings.push_back(*wrong);
}

CameraCheck check_of_rig(const CheckArguments& arguments) {
  const RigInputArguments rig = rig_arguments(arguments.input, arguments.pair, arguments.threads);
  const CameraFile file = read_camera_file(arguments.camera);
  check_folders_of_rig(rig, file, arguments.camera);
  const RigInput read = read_rig(rig);
  const KnownRig known = rig_of(read.rig, file, arguments.camera);
  CameraCheck check =
      naming(arguments.camera, [&] { return check_rig(read.rig, known, arguments.options); });
  refuse_wrong_target(read.mistakes, check);
  return check;
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
