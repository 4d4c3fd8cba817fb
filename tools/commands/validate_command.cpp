#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "commands/commands.hpp"
#include "commands/rig_poses.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "job/progress.hpp"
#include "job/terminal.hpp"
#include "report/json_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_file.hpp"
#include "tagcal/validate/validate.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

struct ValidateArguments {
  std::string calibration;
  std::string dataset;
  std::string observations;
  bool truth = false;
  bool json = false;
};

InputArguments input_of(const ValidateArguments& arguments) {
  return {.inputs = {arguments.dataset}, .observations = arguments.observations};
}

// Returns true if all requested checks pass.
bool passes(const Validation& validation, const ValidateArguments& arguments) {
  return validation.opencv_agrees && !(arguments.truth && validation.num_beyond_truth != 0);
}

Json parameters_json(const std::vector<ParameterError>& errors) {
  Json parameters = Json::array();
  for (const ParameterError& p : errors) {
    parameters.push_back({{"name", p.name},
                          {"estimate", p.estimate},
                          {"truth", p.truth},
                          {"sigma", optional_json(p.sigma)},
                          {"in_sigmas", optional_json(p.in_sigmas)}});
  }
  return parameters;
}

Json validation_json(const Validation& validation, const std::string& model, bool passed) {
  return {{"passed", passed},
          {"opencv_agrees", validation.opencv_agrees},
          {"parameters_beyond_5_sd",
           validation.num_beyond_truth ? Json(*validation.num_beyond_truth) : Json()},
          {"model", model.empty() ? Json() : Json(model)},
          {"max_projection_difference_px", validation.max_projection_difference_px},
          {"bound_px", validation.bound_px},
          {"max_jacobian_difference", validation.max_jacobian_difference},
          {"num_compared", validation.num_compared},
          {"num_outside_domain", validation.num_outside_domain},
          {"rms_px", validation.rms_px},
          {"num_views", validation.num_views},
          {"num_without_pose", validation.num_without_pose},
          {"parameters", parameters_json(validation.parameters)},
          {"warnings", validation.warnings}};
}

std::string parameter_table(const std::vector<ParameterError>& parameters) {
  if (parameters.empty()) return "truth: not known\n";
  std::string text = fmt::format("  {:<4} {:>14} {:>12} {:>14} {:>9}\n", "", "estimate", "+- sd",
                                 "truth", "off by");
  for (const ParameterError& p : parameters) {
    if (p.sigma == 0 && p.estimate == 0 && p.truth == 0) continue;  // held at the true value 0
    const Measured m = measured(p.estimate, p.sigma.value_or(0));
    const std::size_t point = m.value.find('.');
    const std::size_t decimals = point == std::string::npos ? 0 : m.value.size() - point - 1;
    const std::string sigma = !p.sigma ? "not known" : m.sigma.empty() ? "held" : m.sigma;
    const std::string off = p.in_sigmas ? fmt::format("{:.2f} sd", *p.in_sigmas)
                                        : fmt::format("{:.3g}", p.estimate - p.truth);
    text += fmt::format("  {:<4} {:>14} {:>12} {:>14.{}f} {:>9}\n", p.name, m.value, sigma, p.truth,
                        p.in_sigmas ? decimals : 6, off);
  }
  return text;
}

// One line per check with its result.
std::string verdicts(const Validation& validation) {
  std::string text = validation.opencv_agrees       ? "OpenCV agrees\n"
                     : validation.num_compared == 0 ? "OpenCV: nothing to compare\n"
                                                    : "OpenCV DISAGREES\n";
  if (const std::optional<int>& n = validation.num_beyond_truth)
    text += fmt::format("truth: {} parameter{} beyond {} sd\n", *n == 0 ? "no" : fmt::to_string(*n),
                        *n < 2 ? "" : "s", kTruthBound);
  return text;
}

// The places of the cameras against the truth, but for the reference's.
std::string place_table(const std::string& name, const std::vector<ParameterError>& place) {
  std::string text = name + "\n";
  for (const ParameterError& p : place)
    text += fmt::format("  {:<14} {:>14.6f} {:>12} {:>14.6f} {:>9}\n", p.name, p.estimate,
                        p.sigma ? two_digits(*p.sigma) : "not known", p.truth,
                        p.in_sigmas ? fmt::format("{:.2f} sd", *p.in_sigmas)
                                    : fmt::format("{:.3g}", p.estimate - p.truth));
  return text;
}

std::string summary(const Validation& validation, const std::string& model) {
  std::string text = fmt::format("model      {}\n", model.empty() ? "not stated" : model);
  text += parameter_table(validation.parameters);
  text +=
      fmt::format("rms        {:.4f} px over {} views{}\n", validation.rms_px, validation.num_views,
                  validation.num_without_pose == 0
                      ? ""
                      : fmt::format(", {} without a pose", validation.num_without_pose));
  text += fmt::format(
      "OpenCV     projections of {} corners differ by {:.2e} px at most (bound {:.0e})\n",
      validation.num_compared, validation.max_projection_difference_px, validation.bound_px);
  text += fmt::format("           Jacobians differ by {:.2e} at most (relative)\n",
                      validation.max_jacobian_difference);
  if (validation.num_outside_domain > 0) {
    text += fmt::format("           {} corners outside the lens' domain, not compared\n",
                        validation.num_outside_domain);
  }
  for (const std::string& warning : validation.warnings) text += "warning: " + warning + "\n";
  return text + verdicts(validation);
}

// Throws Error if --truth has no truth of the same kind of lens, or no standard deviations.
void check_truth(const ValidateArguments& arguments, const CalibrationFile& file,
                 const Input& input) {
  if (!arguments.truth) return;
  const std::optional<Truth>& truth = input.dataset.truth;
  if (!truth) throw Error(fmt::format("--truth: {} has no truth file", input.name));
  if (truth->camera.lens.index() != file.camera.lens.index())
    throw Error(fmt::format("--truth: the lens of {} is of another kind than that of {}",
                            input.name, arguments.calibration));
  if (std::ranges::none_of(file.sigmas, [](double sigma) { return sigma > 0; }))
    throw Error(fmt::format("--truth: {} has no standard deviations", arguments.calibration));
}

// Each camera of a rig against OpenCV and the truth, then their places against the truth.
struct RigValidation {
  bool passed = true;
  Json cameras = Json::array(), places = Json::array();
  std::string text;
};

void validate_lenses(const ValidateArguments& arguments, const KnownRig& rig,
                     const CameraFile& file, const RigDataset& data, RigValidation& answer) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const std::string& name = rig.cameras[c].name;
    const auto of_file = std::ranges::find(file.cameras, name, &FileCamera::name);
    const CalibrationFile& known = of_file->calibration;
    const Validation validation =
        validate(known.camera, known.sigmas, data.cameras[c].data, known.camera_error_px);
    const bool passes_alone = passes(validation, arguments);
    answer.passed = answer.passed && passes_alone;
    answer.cameras.push_back(validation_json(validation, known.model, passes_alone));
    answer.cameras.back()["name"] = name;
    answer.text += fmt::format("{}{}\n{}", answer.text.empty() ? "" : "\n", name,
                               summary(validation, known.model));
  }
}

// Returns the numbers of places that are beyond kTruthBound standard deviations.
int validate_places(const KnownRig& rig, const RigTruth& truth, RigValidation& answer) {
  int num_beyond = 0;
  const std::size_t reference = rig.reference().value_or(0);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    if (c == reference) continue;
    const auto place = validate_place(rig, truth, c, reference);
    num_beyond += static_cast<int>(std::ranges::count_if(place, [](const ParameterError& p) {
      return p.in_sigmas && !(std::abs(*p.in_sigmas) <= kTruthBound);
    }));
    answer.places.push_back({{"name", rig.cameras[c].name}, {"place", parameters_json(place)}});
    answer.text += place_table(
        fmt::format("\n{} from {}", rig.cameras[c].name, rig.cameras[reference].name), place);
  }
  answer.text += fmt::format("truth of the places: {} number{} beyond {} sd\n",
                             num_beyond == 0 ? "no" : fmt::to_string(num_beyond),
                             num_beyond < 2 ? "" : "s", kTruthBound);
  return num_beyond;
}

int run_rig(const ValidateArguments& arguments) {
  const RigDataset data = read_rig(rig_arguments(input_of(arguments), "name", 0)).rig;
  const CameraFile file = read_camera_file(arguments.calibration);
  const KnownRig rig = rig_of(data, file, arguments.calibration);
  if (arguments.truth && !data.truth)
    throw Error(fmt::format("--truth: {} has no truth file", arguments.dataset));
  RigValidation answer;
  validate_lenses(arguments, rig, file, data, answer);
  std::optional<int> num_beyond;
  if (data.truth) num_beyond = validate_places(rig, *data.truth, answer);
  answer.passed = answer.passed && !(arguments.truth && *num_beyond > 0);
  const Json json = {{"passed", answer.passed},
                     {"places_beyond_5_sd", num_beyond ? Json(*num_beyond) : Json()},
                     {"cameras", answer.cameras},
                     {"places", answer.places}};
  print_answer(arguments.json ? json_text(json) : answer.text, arguments.json);
  return answer.passed ? kAnswer : kCheckFailed;
}

int run(const ValidateArguments& arguments) {
  if (is_rig_folder(arguments.dataset)) return run_rig(arguments);
  const CalibrationFile file = read_camera(arguments.calibration);
  Input input = read_input(input_of(arguments));
  check_image_size(file.camera.image_size, arguments.calibration, input);
  check_truth(arguments, file, input);
  need_views(input, 0);
  Validation validation;
  {
    const Progress progress("validating");
    validation = validate(file.camera, file.sigmas, input.dataset, file.camera_error_px);
  }
  validation.warnings.insert(validation.warnings.begin(), input.warnings.begin(),
                             input.warnings.end());
  const bool passed = passes(validation, arguments);
  print_answer(arguments.json ? json_text(validation_json(validation, file.model, passed))
                              : summary(validation, file.model),
               arguments.json);
  return passed ? kAnswer : kCheckFailed;
}

}  // namespace

Command add_validate(CLI::App& app) {
  CLI::App* command =
      add_command(app, "validate", "a calibration against OpenCV's projection and the truth");
  const auto arguments = std::make_shared<ValidateArguments>();
  add_option(*command, "CALIBRATION", arguments->calibration,
             "a camera's file, of any format (tagcal convert), or that of a rig")
      .required();
  add_option(*command, "--dataset", arguments->dataset,
             "a folder with dataset.yaml; of a rig for the file of a rig")
      .text("DATASET")
      .required();
  add_option(*command, "--observations", arguments->observations,
             "corners found before (tagcal detect), instead of those of the data set; of a rig a "
             "file for each camera: CSV,CSV")
      .text("CSV");
  add_flag(*command, "--truth", arguments->truth,
           "exit 1 if a parameter is more than 5 standard deviations off the truth");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_footer(*command,
             "Example: tagcal validate camera.yaml --dataset desk --observations corners.csv");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
