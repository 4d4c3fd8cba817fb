// Renders random worlds and finds their tags, or projects their corners; calibrates their cameras
// with `auto`, and compares every number that is claimed with the truth (docs/trust/worlds.md).
//   worlds run --first N --count N --out FILE.csv [--threads T] [--seed S] [--corners-only]
//              [--with DEFECTS] [--without DEFECTS]
//   worlds merge FILE.csv... [--out FILE.csv] [--page FILE.md] [--against FILE.csv]
//   worlds worst FILE.csv... --out DIR [--count K] [--by KIND]
//   worlds scene --index N --out FILE.yaml [--seed S] [--corners-only] [--with ..] [--without ..]
// `run` judges the worlds that are missing in its file, so that it can be stopped and called again.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "worlds/draw.hpp"
#include "worlds/judge.hpp"
#include "worlds/record.hpp"
#include "worlds/scene_text.hpp"
#include "worlds/summary.hpp"
#include "worlds/totals.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> files;
  std::string out, page, by = "beyond";
  std::vector<std::string> against;
  WorldId id{1};  // of all worlds that are drawn, but for the index
  std::vector<std::string> with, without;
  bool corners_only = false;
  std::uint64_t first = 0, count = 1000;
  std::size_t worst = 20;
  int threads = 2;
};

// Appends lines to a file from several threads. A line that was cut short by a stop is removed.
class RecordFile {
 public:
  explicit RecordFile(const std::string& file) {
    std::string text = record_header();
    if (fs::exists(file)) {
      for (const Record& r : read_records(file)) {
        done_.insert(r);
        text += record_line(r);
      }
    }
    write_whole(file, text);
    out_.open(file, std::ios::app);
  }

  bool has(const WorldId& id) const { return done_.contains(id); }

  void add(const Record& record) {
    const std::scoped_lock lock(mutex_);
    out_ << record_line(record) << std::flush;
    if (!out_) throw Error("the file of worlds cannot be written");
  }

 private:
  std::set<WorldId> done_;
  std::ofstream out_;
  std::mutex mutex_;
};

int run(const Arguments& arguments) {
  RecordFile file(arguments.out);
  std::vector<WorldId> missing;
  WorldId id = arguments.id;
  for (id.index = arguments.first; id.index < arguments.first + arguments.count; ++id.index)
    if (!file.has(id)) missing.push_back(id);
  parallel_for(missing.size(), arguments.threads,
               [&](std::size_t i) { file.add(judge(draw_world(missing[i]))); });
  fmt::print("{}: {} worlds added, {} were there\n", arguments.out, missing.size(),
             arguments.count - missing.size());
  return 0;
}

// The records of all files, each world once.
std::vector<Record> merged(const std::vector<std::string>& files) {
  std::map<WorldId, Record> all;
  for (const std::string& file : files)
    for (const Record& r : read_records(file)) all[r] = r;
  std::vector<Record> records;
  for (const auto& [id, record] : all) records.push_back(record);
  return records;
}

std::vector<Record> worst_of(const Arguments& arguments) {
  const Wrong kind = wrong_named(arguments.by);
  std::vector<Record> records = merged(arguments.files);
  std::erase_if(records, [&](const Record& r) { return !(wrongness(r, kind) > 1); });
  std::ranges::stable_sort(records, std::greater{},
                           [&](const Record& r) { return wrongness(r, kind); });
  if (records.size() > arguments.worst) records.resize(arguments.worst);
  return records;
}

int merge(const Arguments& arguments) {
  const std::vector<Record> records = merged(arguments.files);
  if (!arguments.out.empty()) {
    std::string text = record_header();
    for (const Record& r : records) text += record_line(r);
    write_whole(arguments.out, text);
  }
  const std::string table = summary(records, merged(arguments.against));
  if (!arguments.page.empty()) write_whole(arguments.page, table);
  fmt::print("{}\nworst\n", table);
  for (const Record& r : worst_of(arguments)) fmt::print("{}\n", one_line(r));
  return 0;
}

// A bent board needs a second file, because `tagcal render` states the board that it renders.
void write_scene(const World& world, const fs::path& file) {
  const std::string text = scene_text(real_scene(world));
  write_whole(file, text);
  // The file must give this very scene.
  if (scene_text(read_scene(file)) != text)
    throw Error(file.string() + ": is read back as another scene");
  fmt::print("tagcal render {} --out DIR --seed {}\n", file.string(), render_seed(world));
  if (!world.defects.of_board()) return;
  const fs::path target = fs::path(file).replace_extension(".target.yaml");
  write_target(target, world.scene.boards[0].board);
  fmt::print("cp {} DIR/target.yaml\n", target.string());
}

void write_corners_of(const World& world, const fs::path& folder) {
  Record record;
  Dataset dataset = project_corners(world, record).dataset;
  const Scene& scene = world.scene;
  const auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
  dataset.truth = Truth{scene.camera, scene.model, {}, {}, {}};
  for (std::size_t i = 0; i < poses.size(); ++i)
    dataset.truth->camera_from_world[dataset.views[i].image] = poses[i];
  write_dataset(folder, dataset, "", "corners.csv");
  write_whole(folder / "corners.csv", observations_csv(dataset.views));
  fmt::print("tagcal calibrate {}\n", folder.string());
}

int worst(const Arguments& arguments) {
  fs::create_directories(arguments.out);
  for (const Record& r : worst_of(arguments)) {
    fmt::print("{}\n", one_line(r));
    const std::string name = fmt::format("w{}_{}{}", r.seed, r.index, r.switches);
    if (r.mode == kCorners)
      write_corners_of(draw_world(r), fs::path(arguments.out) / name);
    else
      write_scene(draw_world(r), fs::path(arguments.out) / (name + ".yaml"));
  }
  return 0;
}

int scene(const Arguments& arguments) {
  const World world = draw_world(arguments.id);
  if (arguments.corners_only)
    write_corners_of(world, arguments.out);
  else
    write_scene(world, arguments.out);
  return 0;
}

void add_world_options(CLI::App& command, Arguments& a) {
  command.add_option("--seed", a.id.seed, "of all worlds (1)");
  command.add_flag("--corners-only", a.corners_only,
                   "no pictures: exact corners of the same cameras, boards and poses, with noise");
  command.add_option("--with", a.with, "defects that every world has")->delimiter(',');
  command.add_option("--without", a.without, "defects that no world has")->delimiter(',');
  command.footer(
      fmt::format("Defects, and the share of the worlds that have them:\n{}", help_on_defects()));
}

void add_options(CLI::App& on_run, CLI::App& on_merge, CLI::App& on_worst, CLI::App& on_scene,
                 Arguments& a) {
  on_run.add_option("--first", a.first, "index of the first world (0)");
  on_run.add_option("--count", a.count, "number of worlds (1000)");
  on_run.add_option("--threads", a.threads, "worlds judged side by side (2)")
      ->check(CLI::Range(1, 1024));
  for (CLI::App* c : {&on_run, &on_scene}) add_world_options(*c, a);
  on_scene.add_option("--index", a.id.index, "of the world")->required();
  for (CLI::App* c : {&on_merge, &on_worst}) {
    c->add_option("FILES", a.files, "files that `run` wrote")->required();
    c->add_option("--count", a.worst, "number of worst worlds (20)");
    c->add_option("--by", a.by,
                  "beyond, focal, region, image, corners, refused or diagnosis (beyond)");
  }
  on_merge.add_option("--page", a.page, "write the tables, in Markdown");
  on_merge.add_option("--against", a.against, "records of the same worlds by another version");
  for (CLI::App* c : {&on_run, &on_worst, &on_scene, &on_merge})
    c->add_option("--out", a.out,
                  c == &on_worst   ? "folder to write"
                  : c == &on_scene ? "scene to write; with --corners-only the folder of a data set"
                                   : "file to write")
        ->required(c != &on_merge);
}

int command(int argc, char** argv) {
  Arguments a;
  CLI::App app("Random worlds, from pixels or corners to the calibration (docs/trust/worlds.md).");
  app.require_subcommand(1);
  CLI::App* on_run = app.add_subcommand("run", "judge the worlds that are missing in a file");
  CLI::App* on_merge = app.add_subcommand("merge", "print the tables of files of worlds");
  CLI::App* on_worst = app.add_subcommand("worst", "write the worst worlds");
  CLI::App* on_scene = app.add_subcommand("scene", "write one world");
  add_options(*on_run, *on_merge, *on_worst, *on_scene, a);
  CLI11_PARSE(app, argc, argv);
  if (a.corners_only) a.id.mode = kCorners;
  a.id.switches = switches_text(a.with, a.without, a.id.mode);
  if (*on_run) return run(a);
  if (*on_merge) return merge(a);
  if (*on_worst) return worst(a);
  return scene(a);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  try {
    return tagcal::command(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "worlds: %s\n", error.what());
    return 2;
  }
}
