#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "draw/canvas.hpp"
#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/progress.hpp"
#include "studies/studies.hpp"
#include "study/chart/chart.hpp"
#include "study/chart/chart_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
using namespace study;
namespace {

namespace fs = std::filesystem;

struct ChartArguments {
  std::string job, out;
  int trials = 0, threads = 1, seed = 1;
  bool quick = false;
};

std::string shown_command(const ChartArguments& a, const std::string& job) {
  std::string text = fmt::format("tagcal chart {}", job);
  if (a.trials > 0) text += fmt::format(" --trials {}", a.trials);
  if (a.quick) text += " --quick";
  return text + fmt::format(" --seed {}", a.seed);
}

// Writes the pictures, the tables and the trials of a result.
void write_result(const ChartResult& result, const fs::path& place, OutputFolder& folder) {
  const std::vector<ChartPoint> points = chart_points(result);
  write_whole(folder.path() / "trials.csv", trials_text(result));
  write_whole(folder.path() / "chart.csv", points_csv(result, points));
  write_whole(folder.path() / "chart.md", chart_markdown(result, points));
  for (const auto& [name, drawing] : chart_pictures(result, points)) {
    write_whole(folder.path() / (name + ".svg"), drawing_svg(drawing));
    write_png(folder.path() / (name + ".png"), drawing_image(drawing, 2));
  }
  folder.publish();
  say_wrote(place);
  fmt::print("{}: {} panels, {} methods, {} trials a panel; see chart.md and chart.png\n",
             place.string(), result.panels.size(), result.methods.size(), result.num_trials);
}

ChartResult run_job(const ChartArguments& a, const std::string& name) {
  const ChartOptions options{a.trials, static_cast<std::uint64_t>(a.seed), a.threads, a.quick};
  Progress progress("chart " + name);
  ChartResult result = run_chart(*chart_job(name), options,
                                 [&](int done, int total) { progress.update(done, total); });
  result.origin = origin_of(shown_command(a, name));
  return result;
}

// Reports a folder that cannot be written before the work, not after it.
void chart(const ChartArguments& a, const std::string& name, const fs::path& place) {
  OutputFolder folder(place, OutputFolder::Taken::by_any_folder);
  write_result(run_job(a, name), place, folder);
}

void check(const ChartArguments& a) {
  if (a.job == "all" || chart_job(a.job)) return;
  throw Error(fmt::format("chart: unknown job {}; known: {}, all", a.job,
                          fmt::join(chart_job_names(), ", ")));
}

int run(const ChartArguments& a) {
  check(a);
  if (a.job == "all") {
    for (const std::string_view name : chart_job_names())
      chart(a, std::string(name), fs::path(a.out) / name);
  } else {
    chart(a, a.job, a.out);
  }
  return kAnswer;
}

}  // namespace

Command add_chart(CLI::App& app) {
  CLI::App* command =
      add_command(app, "chart", "speed and accuracy of the methods of tagcal and other libraries");
  const auto a = std::make_shared<ChartArguments>();
  add_option(
      *command, "JOB", a->job,
      fmt::format("{}, or all: each in a folder of its own", fmt::join(chart_job_names(), ", ")))
      .required();
  add_option(*command, "--out", a->out, "folder for chart.csv, .md, .svg, .png and trials.csv")
      .text("DIR")
      .required();
  add_integer(*command, "--trials", a->trials, 1,
              "trials of each panel; default: the number of the job");
  add_integer(*command, "--seed", a->seed, 0,
              "seed of the problems (1); equal seeds give equal errors");
  add_integer(*command, "--threads", a->threads, 0,
              "problems to solve in parallel; 0: one per core; 1 gives the most accurate times");
  add_flag(*command, "--quick", a->quick, "fewer trials and smaller problems: under a minute");
  add_footer(*command, "Example: tagcal chart pose --quick --out charts");
  return {command, [a] { return run(*a); }};
}

}  // namespace tagcal::tools
