#include <fmt/format.h>

#include <CLI/App.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "commands.hpp"
#include "input.hpp"
#include "progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/study/validate.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string calibration;
  std::string dataset;
  std::string observations;
  bool json = false;
};

std::string json_text(const Validation& validation, const std::string& model) {
  Json parameters = Json::array();
  for (const ParameterError& p : validation.parameters) {
    parameters.push_back({{"name", p.name},
                          {"estimate", p.estimate},
                          {"truth", p.truth},
                          {"sigma", p.sigma},
                          {"in_sigmas", p.in_sigmas}});
  }
  const Json answer = {{"passed", validation.passed},
                       {"model", model.empty() ? Json() : Json(model)},
                       {"max_projection_difference_px", validation.max_projection_difference_px},
                       {"bound_px", validation.bound_px},
                       {"max_jacobian_difference", validation.max_jacobian_difference},
                       {"num_compared", validation.num_compared},
                       {"num_outside_domain", validation.num_outside_domain},
                       {"rms_px", validation.rms_px},
                       {"num_views", validation.num_views},
                       {"parameters", parameters},
                       {"warnings", validation.warnings}};
  return answer.dump(2) + "\n";
}

std::string parameter_table(const std::vector<ParameterError>& parameters) {
  if (parameters.empty()) return "truth: not known\n";
  std::string text = fmt::format("  {:<4} {:>14} {:>12} {:>14} {:>9}\n", "", "estimate", "+- sd",
                                 "truth", "off by");
  for (const ParameterError& p : parameters) {
    if (p.sigma == 0 && p.estimate == 0 && p.truth == 0) continue;  // held, and rightly so
    const std::string sigma = p.sigma > 0 ? fmt::format("{:.6f}", p.sigma) : "held";
    text += fmt::format("  {:<4} {:>14.6f} {:>12} {:>14.6f} {:>6.2f} sd\n", p.name, p.estimate,
                        sigma, p.truth, p.in_sigmas);
  }
  return text;
}

std::string summary(const Validation& validation, const std::string& model) {
  std::string text = fmt::format("model      {}\n", model.empty() ? "not said" : model);
  text += parameter_table(validation.parameters);
  text +=
      fmt::format("rms        {:.4f} px over {} views\n", validation.rms_px, validation.num_views);
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
  text += validation.passed ? "passed\n" : "FAILED\n";
  return text;
}

int run(const Arguments& arguments) {
  const CalibrationFile file = read_calibration(arguments.calibration);
  Input input = read_input({"", {arguments.dataset}, arguments.observations});
  check_image_size(file.camera.image_size, arguments.calibration, input);
  need_views(input, 0);
  Validation validation;
  {
    const Progress progress("validating");
    validation = validate(file.camera, file.sigmas, input.dataset);
  }
  validation.warnings.insert(validation.warnings.begin(), input.warnings.begin(),
                             input.warnings.end());
  print_result(arguments.json ? json_text(validation, file.model)
                              : summary(validation, file.model));
  return validation.passed ? kAnswer : kCheckFailed;
}

}  // namespace

Command add_validate(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("validate", "a calibration against OpenCV's projection and the truth");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("CALIBRATION", arguments->calibration, "a calibration: ours or OpenCV's")
      ->option_text(" ")
      ->required();
  command->add_option("--dataset", arguments->dataset, "a folder with dataset.yaml")
      ->option_text("DATASET REQUIRED")
      ->required();
  command
      ->add_option("--observations", arguments->observations,
                   "corners found before (tagcal detect), instead of those of the data set")
      ->option_text("CSV");
  command->add_flag("--json", arguments->json, "one JSON object on stdout");
  command->footer("Example: tagcal validate camera.yaml --dataset desk --observations corners.csv");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
