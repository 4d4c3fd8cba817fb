// Renders random worlds, finds their tags, calibrates their cameras with `auto`, and compares every
// number that is claimed with the truth (docs/worlds.md).
//   worlds run --first N --count N --out FILE.csv [--threads T] [--seed S]
//   worlds merge FILE.csv... [--out FILE.csv] [--page FILE.md] [--against FILE.csv]
//   worlds worst FILE.csv... --out DIR [--count K] [--by KIND]
//   worlds scene --index N --out FILE.yaml [--seed S]
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
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "worlds/draw.hpp"
#include "worlds/judge.hpp"
#include "worlds/record.hpp"
#include "worlds/scene_text.hpp"
#include "worlds/summary.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> files;
  std::string out, page, by = "beyond";
  std::vector<std::string> against;
  std::uint64_t seed = 1, first = 0, index = 0;
  std::uint64_t count = 1000;
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
        done_.insert({r.seed, r.index});
        text += record_line(r);
      }
    }
    write_whole(file, text);
    out_.open(file, std::ios::app);
  }

  bool has(std::uint64_t seed, std::uint64_t index) const { return done_.contains({seed, index}); }

  void add(const Record& record) {
    const std::scoped_lock lock(mutex_);
    out_ << record_line(record) << std::flush;
    if (!out_) throw Error("the file of worlds cannot be written");
  }

 private:
  std::set<std::pair<std::uint64_t, std::uint64_t>> done_;
  std::ofstream out_;
  std::mutex mutex_;
};

int run(const Arguments& arguments) {
  RecordFile file(arguments.out);
  std::vector<std::uint64_t> missing;
  for (std::uint64_t i = arguments.first; i < arguments.first + arguments.count; ++i)
    if (!file.has(arguments.seed, i)) missing.push_back(i);
  parallel_for(missing.size(), arguments.threads,
               [&](std::size_t i) { file.add(judge(draw_world(arguments.seed, missing[i]))); });
  fmt::print("{}: {} worlds added, {} were there\n", arguments.out, missing.size(),
             arguments.count - missing.size());
  return 0;
}

// The records of all files by seed and index, each once.
std::vector<Record> merged(const std::vector<std::string>& files) {
  std::map<std::pair<std::uint64_t, std::uint64_t>, Record> all;
  for (const std::string& file : files)
    for (const Record& r : read_records(file)) all[{r.seed, r.index}] = r;
  std::vector<Record> records;
  for (const auto& [key, record] : all) records.push_back(record);
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

void write_scene(const World& world, const fs::path& file) {
  write_whole(file, scene_text(world.scene));
  // The file must give this very scene.
  if (scene_text(read_scene(file)) != scene_text(world.scene))
    throw Error(file.string() + ": is read back as another scene");
  fmt::print("tagcal render {} --out DIR --seed {}\n", file.string(), render_seed(world));
}

int worst(const Arguments& arguments) {
  fs::create_directories(arguments.out);
  for (const Record& r : worst_of(arguments)) {
    fmt::print("{}\n", one_line(r));
    write_scene(draw_world(r.seed, r.index),
                fs::path(arguments.out) / fmt::format("w{}_{}.yaml", r.seed, r.index));
  }
  return 0;
}

int scene(const Arguments& arguments) {
  write_scene(draw_world(arguments.seed, arguments.index), arguments.out);
  return 0;
}

int command(int argc, char** argv) {
  Arguments a;
  CLI::App app("Random worlds, from pixels to the calibration (docs/worlds.md).");
  app.require_subcommand(1);
  CLI::App* on_run = app.add_subcommand("run", "judge the worlds that are missing in a file");
  CLI::App* on_merge = app.add_subcommand("merge", "print the tables of files of worlds");
  CLI::App* on_worst = app.add_subcommand("worst", "write the worst worlds as scenes");
  CLI::App* on_scene = app.add_subcommand("scene", "write one world as a scene");
  on_run->add_option("--first", a.first, "index of the first world (0)");
  on_run->add_option("--count", a.count, "number of worlds (1000)");
  on_run->add_option("--threads", a.threads, "worlds judged side by side (2)")
      ->check(CLI::Range(1, 1024));
  for (CLI::App* c : {on_run, on_scene}) c->add_option("--seed", a.seed, "of all worlds (1)");
  on_scene->add_option("--index", a.index, "of the world")->required();
  for (CLI::App* c : {on_merge, on_worst}) {
    c->add_option("FILES", a.files, "files that `run` wrote")->required();
    c->add_option("--count", a.worst, "number of worst worlds (20)");
    c->add_option("--by", a.by,
                  "beyond, focal, region, image, corners, refused or diagnosis (beyond)");
  }
  on_merge->add_option("--page", a.page, "write the tables, in Markdown");
  on_merge->add_option("--against", a.against, "records of the same worlds by another version");
  for (CLI::App* c : {on_run, on_worst, on_scene, on_merge})
    c->add_option("--out", a.out, "file to write; of `worst` a folder")->required(c != on_merge);
  CLI11_PARSE(app, argc, argv);
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
