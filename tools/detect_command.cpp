#include <fmt/format.h>

#include <CLI/App.hpp>
#include <memory>
#include <string>

#include "arguments.hpp"
#include "commands.hpp"
#include "input.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

struct Arguments {
  InputArguments input;
  std::string out;
  int threads = 0;
};

int run(const Arguments& arguments) {
  check_writable(arguments.out);
  Input input = read_input(arguments.input);
  detect_views(input, arguments.threads);
  const std::vector<View>& views = input.dataset.views;
  const std::string csv = observations_csv(views);
  if (arguments.out.empty()) {
    print_result(csv);
  } else {
    write_whole(arguments.out, csv);
  }
  if (num_corners(views) == 0) input.warnings.push_back("no tag found in any picture");
  print_warnings(input.warnings);
  fmt::print(stderr, "{} images, {} tags, {} corners\n", input.images.size(), num_tags(views),
             num_corners(views));
  return kAnswer;
}

}  // namespace

Command add_detect(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("detect", "corners of a target's tags in pictures, as CSV");
  const auto arguments = std::make_shared<Arguments>();
  add_input(*command, arguments->input);
  command->add_option("--out", arguments->out, "file for the corners, instead of stdout")
      ->option_text("CSV");
  add_threads(*command, arguments->threads);
  command->footer(
      "Example: tagcal detect desk --out corners.csv\n"
      "         tagcal detect --target board.yaml photos/*.jpg > corners.csv");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
