#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "draw/canvas.hpp"
#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/progress.hpp"
#include "studies/studies.hpp"
#include "study/atlas/atlas_page.hpp"
#include "study/atlas/stability.hpp"
#include "study/atlas/stability_file.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
using namespace study;
namespace {

namespace fs = std::filesystem;

struct StabilityArguments {
  std::vector<std::string> maps;
  std::string out, from;
  int trials = 0, threads = 1;
  std::uint64_t seed = 1;
  bool quick = false, list = false, ours = false;
};

// The named maps in the order of the atlas; all maps if none is named.
std::vector<StabilityMap> chosen_maps(const std::vector<std::string>& names) {
  const std::vector<StabilityMap> all = stability_maps();
  std::vector<std::string> known;
  for (const StabilityMap& map : all) known.push_back(map.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(
          fmt::format("stability: unknown map {}; known: {}", name, fmt::join(known, ", ")));
  if (names.empty()) return all;
  std::vector<StabilityMap> chosen;
  for (const StabilityMap& map : all)
    if (std::find(names.begin(), names.end(), map.name) != names.end()) chosen.push_back(map);
  return chosen;
}

std::string shown_command(const StabilityArguments& a) {
  std::string command = "tagcal stability";
  for (const std::string& name : a.maps) command += " " + name;
  if (a.trials > 0) command += fmt::format(" --trials {}", a.trials);
  if (a.quick) command += " --quick";
  if (a.ours) command += " --ours";
  return command + fmt::format(" --seed {}", a.seed);
}

StabilityResult run_shown(const StabilityMap& map, const StabilityArguments& a) {
  const StabilityOptions options{a.seed, a.threads, a.quick, a.trials};
  Progress progress("stability " + map.name);
  return run_map(map, options, [&](int done, int total) { progress.update(done, total); });
}

int run(const StabilityArguments& a) {
  std::vector<StabilityMap> maps = chosen_maps(a.maps);
  if (a.list) {
    for (const StabilityMap& map : maps) fmt::print("{:<20} {}\n", map.name, map.title);
    return kAnswer;
  }
  if (a.out.empty()) throw Error("stability: needs --out DIR, or --list");
  OutputFolder folder(a.out, OutputFolder::Taken::by_any_folder);
  const std::vector<std::string> origin =  // of maps that were read: other versions and machines
      a.from.empty() ? origin_of(shown_command(a)) : std::vector{shown_command(a)};
  std::vector<AtlasSheet> sheets;
  int misses = 0;
  for (StabilityMap& map : maps) {
    if (a.ours) map = ours_alone(std::move(map));
    const fs::path made = fs::path(a.from) / (map.name + ".csv");
    const bool is_made = !a.from.empty() && fs::exists(made);
    StabilityResult result = is_made ? read_stability(map, read_text(made)) : run_shown(map, a);
    write_whole(folder.path() / (map.name + ".csv"), stability_csv(map, result));
    write_png(folder.path() / (map.name + ".png"),
              drawing_image(atlas_picture(map, result, origin), 2));
    sheets.push_back({std::move(map), std::move(result)});
    misses += static_cast<int>(missing_marks(sheets.back().map, sheets.back().result).size());
  }
  write_whole(folder.path() / "atlas.md", atlas_page(sheets, origin));
  folder.publish();
  say_wrote(a.out);
  fmt::print("{}: {} maps, {} cells or maps of tagcal miss the marks; see atlas.md\n", a.out,
             sheets.size(), misses);
  return kAnswer;
}

}  // namespace

Command add_stability(CLI::App& app) {
  CLI::App* command =
      add_command(app, "stability", "maps of where the methods of tagcal and other libraries fail");
  const auto a = std::make_shared<StabilityArguments>();
  add_option(*command, "MAP", a->maps, "names of maps (see --list); default: all");
  add_option(*command, "--out", a->out, "folder for atlas.md and each map's .csv and .png")
      .text("DIR");
  add_option(*command, "--from", a->from,
             "folder of maps' .csv that earlier runs made: these maps are read, not run again")
      .text("DIR");
  add_integer(*command, "--trials", a->trials, 1,
              "trials of each cell (other libraries: at most 200); default: the number of the map");
  add_option(*command, "--seed", a->seed, "seed of the problems; equal seeds give equal outcomes")
      .text("N");
  add_integer(*command, "--threads", a->threads, 0,
              "problems to solve in parallel; 0: one per core; 1 gives the most accurate times");
  add_flag(*command, "--quick", a->quick, "few trials: all maps in about a minute");
  add_flag(*command, "--ours", a->ours,
           "tagcal's methods only, without the slower ones of other libraries");
  add_flag(*command, "--list", a->list, "print the names and titles of the maps only");
  add_footer(*command, "Example: tagcal stability tag-tilt-distance --quick --out atlas");
  return {command, [a] { return run(*a); }};
}

}  // namespace tagcal::tools
