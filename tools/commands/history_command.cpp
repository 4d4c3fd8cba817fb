#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "report/history_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct HistoryArguments {
  std::vector<std::string> cameras;
  std::string key;
  std::string values;  // CSV
  std::string out;     // .csv or .json
  bool json = false;
};

void check_out(const HistoryArguments& arguments) {
  const fs::path out = arguments.out;
  if (out.empty()) return;
  if (out.extension() != ".csv" && out.extension() != ".json")
    throw Error(fmt::format("{}: must end in .csv or .json", out.string()));
  check_text_writable(out);
  std::vector<fs::path> inputs(arguments.cameras.begin(), arguments.cameras.end());
  inputs.emplace_back(arguments.values);
  check_replaces_nothing({out}, inputs);
}

int run(const HistoryArguments& arguments) {
  check_out(arguments);
  const HistoryInput input = read_history(arguments.cameras, arguments.key, arguments.values);
  const CameraHistory history = history_of(input);
  const std::string json = json_text(history_json(history, input));
  if (const fs::path out = arguments.out; !out.empty()) {
    write_whole(out, out.extension() == ".csv" ? history_csv(input) : json);
    say_wrote(out, fmt::format("{} calibrations", input.names.size()));
  }
  print_answer(arguments.json ? json : history_text(history, input), arguments.json, arguments.out);
  if (history.verdict == HistoryVerdict::too_few) return kNoAnswer;
  return history.verdict == HistoryVerdict::stable ? kAnswer : kCheckFailed;
}

}  // namespace

Command add_history(CLI::App& app) {
  CLI::App* command = add_command(
      app, "history", "calibrations of one camera: if it is stable, drifts, or changed");
  const auto arguments = std::make_shared<HistoryArguments>();
  add_option(*command, "CAMERA", arguments->cameras,
             "calibrations of one camera, of one model, by tagcal calibrate")
      .required();
  add_option(*command, "--key", arguments->key,
             "by this number in each file, such as temperature_c; default: days, if all names end "
             "with a date as cam7_2026-03-01, else the order")
      .text("NAME");
  add_option(*command, "--values", arguments->values,
             "the numbers are in a table with the columns name and NAME, or name and value")
      .text("CSV");
  add_option(*command, "--out", arguments->out, "the calibrations as .csv, or the answer as .json")
      .text("FILE");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_footer(*command,
             "Exit code: 0 stable, 1 trend or change, 3 too few\n"
             "Example: tagcal history cam7_*.yaml\n"
             "         tagcal history cold.yaml warm.yaml hot.yaml --key temperature_c");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
