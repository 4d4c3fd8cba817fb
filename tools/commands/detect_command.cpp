#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "commands/commands.hpp"
#include "commands/detect_tags_run.hpp"
#include "draw/tag_drawing.hpp"
#include "job/arguments.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "job/progress.hpp"
#include "report/detection_report.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

struct DetectArguments {
  InputArguments input;
  std::string out;
  std::string camera;  // a file
  std::string draw;    // a folder
  bool explain = false;
  bool verbose = false;
  bool json = false;
  int border_bits = 0;  // 0: not given
  int threads = 0;
};

std::string ids_text(const std::vector<int>& ids) {
  return ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, " "));
}

std::string explanation_text(const std::string& name, const Explanation& e, bool has_tags) {
  std::string text = fmt::format("{}: {}x{} pixels, {} four-sided shapes\n", name, e.size.width,
                                 e.size.height, e.quads);
  for (const SeenKind& kind : e.decoded) {
    text += fmt::format("  can be read as {}, border_bits {}: {} tags: {}\n", kind.family,
                        kind.border_bits, kind.ids.size(), ids_text(kind.ids));
  }
  if (has_tags) {
    text += fmt::format("  reported: {} tags: {}\n", e.reported.size(), ids_text(e.reported));
  }
  for (const std::string& board : e.checkerboards) text += fmt::format("  {}\n", board);
  std::map<std::string, std::vector<int>> by_reason;
  for (const NotReported& tag : e.not_reported) by_reason[tag.why].push_back(tag.id);
  for (const auto& [why, ids] : by_reason) {
    text += fmt::format("  not reported, {}: {}\n", why, ids_text(ids));
  }
  for (const std::string& mistake : e.mistakes) text += fmt::format("  {}\n", mistake);
  return text;
}

void explain_all(const Input& input) {
  std::string text;
  {
    Progress progress("explaining", static_cast<int>(input.images.size()));
    for (std::size_t i = 0; i < input.images.size(); ++i) {
      const ImageSource& image = input.images[i];
      text += explanation_text(image.name, explain(image.load(), input.dataset.boards),
                               has_tags(input.dataset.boards));
      progress.update(static_cast<int>(i + 1));
    }
  }
  print_to_stderr("{}", text);
}

int run_without_target(const DetectArguments& a) {
  if (!a.input.target.empty())
    throw Error("--family, --target: only one of the two is possible; the target has its family");
  if (a.explain) throw Error("--explain: needs a target");
  if (a.input.tag_size_m > 0) throw Error("--tag-size: corners have none; pose --family takes it");
  return run_tag_search(
      {a.input, std::max(1, a.border_bits), a.out, a.camera, a.draw, a.threads, a.verbose, a.json});
}

int run(const DetectArguments& arguments) {
  if (!arguments.input.family.empty()) return run_without_target(arguments);
  if (arguments.border_bits > 0) throw Error("--border-bits: needs --family");
  check_text_writable(arguments.out);
  check_replaces_nothing({arguments.out}, {arguments.camera});
  InputArguments with_cache = arguments.input;
  with_cache.out = arguments.out;
  Input input = read_input(with_cache);
  std::optional<OutputFolder> drawings;
  if (!arguments.draw.empty()) drawing_names(input, arguments.draw);  // throws before the work
  if (!arguments.draw.empty()) drawings.emplace(arguments.draw, OutputFolder::Taken::by_any_folder);
  const std::optional<Camera> camera = known_camera(arguments.camera, input);
  detect_views(input, arguments.threads, true, camera ? &*camera : nullptr);
  const std::string csv = observations_csv(input.dataset.views, input.times_s);
  write_table(csv, arguments.out, arguments.json);
  if (drawings)
    draw_pictures(input, arguments.draw, *drawings, [&](std::size_t i) {
      return draw_tags(input.images[i].load(), input.dataset.views[i],
                       i < input.unfitted.size() ? input.unfitted[i] : std::vector<UnfittedTag>());
    });
  print_warnings(input.warnings);
  if (arguments.json)
    print_result(json_text(detection_json(input, rows_json(csv, {"image"}))));
  else
    print_summary(detection_summary(input, arguments.verbose, arguments.explain), arguments.out);
  if (arguments.explain) explain_all(input);
  return kAnswer;
}

}  // namespace

Command add_detect(CLI::App& app) {
  CLI::App* command = add_command(app, "detect", "corners of a target in pictures, as CSV");
  const auto arguments = std::make_shared<DetectArguments>();
  add_input(*command, arguments->input);
  add_no_cache(*command, arguments->input.no_cache);
  add_family(
      *command, arguments->input.family,
      "all tags of this family in pictures, without a target; ids may repeat, and the column "
      "`instance` counts them");
  add_integer(
      *command, "--border-bits", arguments->border_bits, 1,
      "width of these tags' black border in cells: 1 (the default), or 2 as on Kalibr's boards")
      .text("N");
  add_option(*command, "--out", arguments->out, "file for the corners, instead of stdout")
      .text("CSV")
      .writes_text();
  add_option(*command, "--camera", arguments->camera,
             "file of the camera, if it is known, of any format (tagcal convert): --refinement fit "
             "then uses its lens")
      .text("CAMERA");
  add_option(
      *command, "--draw", arguments->draw,
      fmt::format("folder for the pictures with tags, ids and corners drawn in, and "
                  "ellipses of {} standard deviations; tags read but not reported are dashed",
                  kEllipseScale))
      .text("DIR");
  add_flag(*command, "--explain", arguments->explain,
           "print per picture, on stderr: the tags that were read, why tags are not reported, and "
           "probable errors of the target file");
  add_flag(*command, "--verbose", arguments->verbose, "also print what each picture shows");
  add_flag(*command, "--json", arguments->json,
           "one JSON object on stdout: what each picture shows, and the corners");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal detect desk --out corners.csv\n"
             "         tagcal detect --target board.yaml photos/*.jpg > corners.csv\n"
             "         tagcal detect --target board.yaml photo.jpg --explain --draw drawn\n"
             "         tagcal detect --family tag36h11 photo.jpg");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
