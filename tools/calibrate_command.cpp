#include <fmt/format.h>

#include <CLI/App.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "arguments.hpp"
#include "calibration_report.hpp"
#include "commands.hpp"
#include "input.hpp"
#include "progress.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "uncertainty_picture.hpp"

namespace tagcal::tools {
namespace {

struct Arguments {
  InputArguments input;
  CalibrateOptions options;
  std::string out;
  std::string uncertainty;  // a picture
  double near_m = 0;        // 0: the corners' median
  int threads = 0;
  bool advise = false;
  bool json = false;
};

void check_picture(const std::filesystem::path& file) {
  if (file.empty() || file.extension() == ".svg" || file.extension() == ".png") return;
  throw Error(fmt::format("{}: must end in .svg or .png", file.string()));
}

void write_picture(const std::filesystem::path& file, const Calibration& calibration) {
  if (file.extension() == ".png")
    write_png(file, uncertainty_image(calibration));
  else
    write_whole(file, uncertainty_svg(calibration));
}

bool is_auto(const std::string& model) { return model.empty() || model == "auto"; }

int run(const Arguments& arguments) {
  const Stopwatch watch;
  check_options(arguments.options);  // before any work
  check_writable(arguments.out);
  check_writable(arguments.uncertainty);
  check_picture(arguments.uncertainty);
  Input input = read_input(arguments.input);
  need_views(input, arguments.threads);
  CommandSeconds seconds;
  seconds.read = watch.seconds();
  Calibration calibration;
  {
    const Progress progress("calibrating");
    CalibrateOptions options = arguments.options;
    if (arguments.near_m > 0) options.distances_m = {kInfinitelyFar, arguments.near_m};
    calibration = calibrate(input.dataset, options);
  }
  calibration.warnings.insert(calibration.warnings.begin(), input.warnings.begin(),
                              input.warnings.end());
  const bool answered = is_answer(calibration.status);
  if (answered && !arguments.out.empty()) {
    write_whole(arguments.out, calibration_yaml(calibration));
  }
  if (answered && !arguments.uncertainty.empty()) write_picture(arguments.uncertainty, calibration);
  const std::optional<AdvisedView> advice =
      arguments.advise ? advise(input.dataset, calibration) : std::nullopt;
  seconds.total = watch.seconds();
  print_result(arguments.json
                   ? calibration_json(calibration, seconds, advice)
                   : calibration_summary(calibration, seconds, is_auto(arguments.options.model)) +
                         advice_text(advice, arguments.advise));
  if (!answered && !arguments.out.empty()) {
    fmt::print(stderr, "tagcal: {}: not written, there is no answer\n", arguments.out);
  }
  if (!answered && !arguments.uncertainty.empty()) {
    fmt::print(stderr, "tagcal: {}: not drawn, there is no answer\n", arguments.uncertainty);
  }
  return answered ? kAnswer : kNoAnswer;
}

std::string model_names() {
  std::string names;
  for (const Model& model : Model::all())
    if (model.num_free() > 0) names += fmt::format(", {}", model.name());
  return names.substr(2);
}

}  // namespace

Command add_calibrate(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "the camera and its standard deviations");
  const auto arguments = std::make_shared<Arguments>();
  add_input(*command, arguments->input);
  add_observations(*command, arguments->input);
  command->add_option("--model", arguments->options.model, "auto, " + model_names())
      ->option_text("M");
  add_positive(*command, "--sigma-px", arguments->options.sigma_px,
               "noise of the corners per coordinate; without it, each corner's own where the file "
               "says it, else from the residuals");
  command->add_option("--out", arguments->out, "file for the camera, where there is an answer")
      ->option_text("FILE");
  command
      ->add_option("--uncertainty", arguments->uncertainty,
                   "picture of the projection's uncertainty over the image, .svg or .png")
      ->option_text("FILE");
  add_positive(*command, "--distance", arguments->near_m,
               "in metres, at which the uncertainty is given beside infinity; without it, the "
               "corners' median");
  command->add_flag("--board-warp", arguments->options.board_warp,
                    "let the board be bent, by two parameters; needs one flat board");
  command->add_flag("--advise", arguments->advise,
                    "the next view that would teach most, and what to expect of it");
  command->add_flag("--json", arguments->json, "one JSON object on stdout");
  add_threads(*command, arguments->threads);
  command->footer(
      "Example: tagcal calibrate desk --observations corners.csv --out camera.yaml\n"
      "         tagcal calibrate --target board.yaml photos/*.jpg --json");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
