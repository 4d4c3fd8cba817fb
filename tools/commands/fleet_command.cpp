#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/input.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "page_data/pages.hpp"
#include "report/fleet.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct FleetArguments {
  std::string folder;
  std::string units;   // CSV
  std::string limits;  // YAML
  std::string out;     // .csv, .json or .html
  bool history = false;
  bool json = false;
  int threads = 0;
};

bool is_page(const fs::path& out) { return out.extension() == ".html"; }

void check_out(const FleetArguments& arguments) {
  const fs::path out = arguments.out;
  const std::string ending = out.extension().string();
  if (!out.empty() && ending != ".csv" && ending != ".json" && !is_page(out))
    throw Error(fmt::format("{}: must end in .csv, .json or .html", out.string()));
  if (is_page(out)) return check_page(out, {arguments.units, arguments.limits});
  check_text_writable(out);
  check_replaces_nothing({out}, {arguments.units, arguments.limits});
}

void write_out(const FleetArguments& arguments, const Fleet& fleet) {
  const fs::path out = arguments.out;
  if (out.empty()) return;
  if (is_page(out)) return write_page(out, fleet_page(fleet, arguments.folder, out));
  write_whole(out, out.extension() == ".csv" ? fleet_csv(fleet) : json_text(fleet_json(fleet)));
  say_wrote(out, fmt::format("{} units", fleet.units.size()));
}

int run(const FleetArguments& arguments) {
  check_out(arguments);
  std::optional<FleetLimits> limits;
  if (!arguments.limits.empty()) limits = read_fleet_limits(arguments.limits);
  const Fleet fleet = judge_fleet(read_fleet(arguments.folder, arguments.units, arguments.threads),
                                  limits, arguments.history, arguments.threads);
  print_warnings(fleet.warnings);
  write_out(arguments, fleet);
  print_answer(arguments.json ? json_text(fleet_json(fleet)) : fleet_text(fleet), arguments.json,
               arguments.out);
  const std::size_t good = fleet.count(UnitVerdict::ok);
  const std::size_t failed = fleet.units.size() - good - fleet.count(UnitVerdict::earlier) -
                             fleet.count(UnitVerdict::not_judged);
  if (failed > 0) return kCheckFailed;
  return good > 0 ? kAnswer : kNoAnswer;
}

}  // namespace

Command add_fleet(CLI::App& app) {
  CLI::App* command = add_command(
      app, "fleet", "many cameras of one make: what is usual, which are unlike it, which drift");
  const auto arguments = std::make_shared<FleetArguments>();
  add_option(*command, "DIR", arguments->folder, "folder of tagcal calibrate --out").required();
  add_option(*command, "--units", arguments->units,
             "table with the columns name, serial, date, temperature_c; default: names such as "
             "cam7_2026-03-01")
      .text("CSV");
  add_option(*command, "--limits", arguments->limits,
             "judge by these limits, not by the population: parameters: {fx: [900, 950]}, rms_px, "
             "displacement_px")
      .text("FILE");
  add_flag(*command, "--history", arguments->history,
           "also how each serial changed over its dates and temperatures");
  add_option(*command, "--out", arguments->out, "all units as .csv or .json, or a page .html")
      .text("FILE");
  add_flag(*command, "--json", arguments->json, "one JSON object on stdout");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal calibrate cameras/* --out fleet --resume\n"
             "         tagcal fleet fleet --out fleet.csv\n"
             "Exit code 1: a unit has no answer, is unlike others, beyond a limit, or drifts");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
