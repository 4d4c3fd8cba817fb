// Renders random worlds and finds their tags, or projects their corners; calibrates their cameras
// with `auto`, and compares every number that is claimed with the truth (docs/trust/worlds.md).
// `run` judges the worlds that are missing in its file, so that it can be stopped and called again.

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "job/arguments.hpp"
#include "studies/studies.hpp"
#include "studies/worlds/draw.hpp"
#include "studies/worlds/judge.hpp"
#include "studies/worlds/record.hpp"
#include "studies/worlds/summary.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kWorlds = 1000, kWorst = 20;

struct WorldsArguments {
  std::string action;
  std::vector<std::string> files;
  std::string out, page, by = "beyond";
  WorldId id{1};  // of all worlds that are drawn, but for the index
  std::vector<std::string> with, without;
  bool corners_only = false;
  std::uint64_t first = 0, count = 0;  // count 0: 1000 worlds of `run`, 20 of the others
  int threads = 2;
};

// One task: the worlds of a seed, a mode and switches, so that a file may have those of several.
Study study_of(const WorldId& id) {
  const auto measure = [id](std::uint64_t index) {
    WorldId one = id;
    one.index = index;
    return std::vector<Values>{record_values(judge(draw_world(one)))};
  };
  const std::string task = fmt::format("{} {}{}", id.mode, id.seed, id.switches);
  return {.name = "worlds",
          .summary = "",
          .columns = record_columns(),
          .tasks = [=](const StudyOptions&) {
            return std::vector<Task>{{task, measure}};
          }};
}

int run(const WorldsArguments& arguments) {
  const Study study = study_of(arguments.id);
  const StudyOptions options{
      .first = arguments.first,
      .count = static_cast<int>(arguments.count > 0 ? arguments.count : kWorlds),
      .threads = arguments.threads,
      .csv = arguments.out};
  int added = 0;
  run_study(study, options, [&](int, int missing) { added = missing; });
  fmt::print("{}: {} worlds added, {} were there\n", arguments.out, added, options.count - added);
  return 0;
}

// The rows of all files, each world once.
std::vector<Row> merged_rows(const std::vector<std::string>& files) {
  std::map<WorldId, Row> all;
  for (const std::string& file : files)
    for (Row& row : read_rows(study_of({}), file)) all[record_of(row)] = std::move(row);
  std::vector<Row> rows;
  for (auto& [id, row] : all) rows.push_back(std::move(row));
  return rows;
}

std::vector<Record> merged(const std::vector<std::string>& files) {
  std::vector<Record> records;
  for (const Row& row : merged_rows(files)) records.push_back(record_of(row));
  return records;
}

std::vector<Record> worst_of(const WorldsArguments& arguments) {
  const Wrong kind = wrong_named(arguments.by);
  std::vector<Record> records = merged(arguments.files);
  std::erase_if(records, [&](const Record& r) { return !(wrongness(r, kind) > 1); });
  std::ranges::stable_sort(records, std::greater{},
                           [&](const Record& r) { return wrongness(r, kind); });
  const std::size_t most = arguments.count > 0 ? arguments.count : kWorst;
  if (records.size() > most) records.resize(most);
  return records;
}

int merge(const WorldsArguments& arguments) {
  if (!arguments.out.empty())
    write_whole(arguments.out, rows_text(study_of({}), {}, merged_rows(arguments.files)));
  const std::string table = summary(merged(arguments.files));
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

int worst(const WorldsArguments& arguments) {
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

int scene(const WorldsArguments& arguments) {
  const World world = draw_world(arguments.id);
  if (arguments.corners_only)
    write_corners_of(world, arguments.out);
  else
    write_scene(world, arguments.out);
  return 0;
}

int run_action(WorldsArguments a) {
  if (a.corners_only) a.id.mode = kCorners;
  a.id.switches = switches_text(a.with, a.without, a.id.mode);
  const bool reads = a.action == "merge" || a.action == "worst";
  if (reads == a.files.empty())
    throw Error(fmt::format("worlds {}: {}", a.action,
                            reads ? "needs files that `run` wrote" : "takes no files"));
  if (a.out.empty() && a.action != "merge")
    throw Error(fmt::format("worlds {}: needs --out", a.action));
  if (a.action == "run") return run(a);
  if (a.action == "merge") return merge(a);
  return a.action == "worst" ? worst(a) : scene(a);
}

}  // namespace

namespace tools {

Command add_worlds(CLI::App& app) {
  CLI::App* command = add_command(
      app, "worlds", "random worlds, from pixels or corners to the calibration, and its claims");
  const auto a = std::make_shared<WorldsArguments>();
  add_option(*command, "ACTION", a->action,
             "run: judge the worlds that are missing in a file; merge: the tables of files; worst: "
             "write the worst worlds; scene: write one world")
      .one_of({"run", "merge", "worst", "scene"})
      .required();
  add_option(*command, "FILE", a->files, "of merge and worst: files that `run` wrote");
  add_option(*command, "--out", a->out,
             "file to write; of worst a folder; of scene with --corners-only the folder of a data "
             "set");
  add_option(*command, "--first", a->first, "run: index of the first world (0)");
  add_option(*command, "--count", a->count,
             "number of worlds (run: 1000), or of worst ones (merge, worst: 20)");
  add_integer(*command, "--threads", a->threads, 0,
              "worlds judged side by side (2); 0: one per core");
  add_option(*command, "--seed", a->id.seed, "of all worlds (1)");
  add_option(*command, "--index", a->id.index, "scene: of the world (0)");
  add_flag(*command, "--corners-only", a->corners_only,
           "no pictures: exact corners of the same cameras, boards and poses, with noise");
  add_option(*command, "--with", a->with, "defects that every world has").separated_by(',');
  add_option(*command, "--without", a->without, "defects that no world has").separated_by(',');
  add_option(*command, "--by", a->by,
             "beyond, focal, region, image, corners, refused or diagnosis (beyond)");
  add_option(*command, "--page", a->page, "merge: write the tables, in Markdown");
  add_footer(*command, fmt::format("Defects, and the share of the worlds that have them:\n{}",
                                   help_on_defects()));
  return {command, [a] { return run_action(*a); }};
}

}  // namespace tools
}  // namespace tagcal
