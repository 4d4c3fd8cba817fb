#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands/calibrate_many.hpp"
#include "commands/commands.hpp"
#include "draw/canvas.hpp"
#include "draw/heat_map.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/digest.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/plain_text.hpp"
#include "job/progress.hpp"
#include "job/terminal.hpp"
#include "page_data/page_parts.hpp"
#include "page_data/pages.hpp"
#include "report/calibration_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  CalibrationJob job;
  std::string out;
  std::string uncertainty;         // a picture
  std::string report;              // a page
  double near_m = 0;               // 0: the corners' median
  std::string start;               // a camera's file
  std::vector<std::string> fixed;  // NAME=VALUE
  std::string until;
  std::string shutter;
  bool one_camera = false;
  bool keep_all = false;
  bool resume = false;
  std::string chunk;  // K/N
  bool verbose = false;
  bool json = false;
};

bool is_auto(const std::string& model) { return model.empty() || model == "auto"; }

void check_usage(const CalibrateArguments& arguments, bool several) {
  if (several && !arguments.report.empty())
    throw Error("--report: shows one camera only; tagcal report shows each calibration file");
  if (several && !arguments.job.keep.empty())
    throw Error("--keep: is the folder for the frames of one camera only");
  if (arguments.resume && (!several || arguments.out.empty()))
    throw Error("--resume: needs several data sets or folders, and --out");
  if (!arguments.chunk.empty() && !arguments.resume)
    throw Error("--chunk: needs --resume, with which several processes can write into one --out");
  if (arguments.uncertainty.empty()) return;
  if (several)
    throw Error("--uncertainty: draws one camera only (each calibration file contains its grid)");
  if (arguments.job.options.model == "weak")
    throw Error("--uncertainty: model weak has no lens to draw");
}

void check_report(const CalibrateArguments& arguments) {
  if (arguments.report.empty()) return;
  const InputArguments& input = arguments.job.input;
  std::vector<std::string> files = input.inputs;
  files.insert(files.end(), {input.target, input.observations, arguments.start});
  check_page(arguments.report, files);
}

// What the camera is called: the folder of its pictures or its data set.
std::string name_of_input(const CalibrateArguments& arguments) {
  const fs::path input = arguments.job.input.inputs.front();
  if (fs::is_directory(input)) return last_part(input.string());
  const fs::path folder = fs::absolute(input).parent_path();
  return last_part(folder.string());
}

void write_report(const CalibrateArguments& arguments, const CalibrationAnswer& answer,
                  Input used) {
  PageContent content;
  content.calibration = answer.calibration;
  content.title = fmt::format("{}: {}", name_of_input(arguments), answer.calibration.model);
  content.chosen = is_auto(arguments.job.options.model);
  content.advice = answer.advice;
  if (!content.advice) content.advice = advise(used.dataset, answer.calibration);
  content.seconds = answer.seconds.total;
  content.pictures = std::move(used.files);
  content.times_s = std::move(used.times_s);
  content.dataset = std::move(used.dataset);
  content.threads = arguments.job.threads;
  write_page(arguments.report, calibration_page(content));
}

// Writes the files that were asked for, and adds the time.
void write_files(const CalibrateArguments& arguments, CalibrationAnswer& answer, Input used) {
  const Stopwatch watch;
  const Calibration& calibration = answer.calibration;
  const bool answered = is_answer(calibration.status);
  if (answered) write_answer_file(arguments.out, calibration_yaml(calibration));
  if (answered && !arguments.uncertainty.empty()) {
    write_drawing(arguments.uncertainty, uncertainty_drawing(calibration));
    say_wrote(arguments.uncertainty);
  }
  if (!arguments.report.empty()) write_report(arguments, answer, std::move(used));
  if (arguments.out.empty() && arguments.uncertainty.empty() && arguments.report.empty()) return;
  answer.seconds.write = watch.seconds();
  answer.seconds.total += answer.seconds.write;
}

// Throws Error, with a file to type, if --out is a folder.
void check_file_of_one(const CalibrateArguments& arguments) {
  const fs::path out = arguments.out;
  if (out.empty() || (out.has_filename() && !fs::is_directory(out)))
    return check_yaml_writable(out);
  const std::string& input = arguments.job.input.inputs.front();
  const std::string name = fs::is_directory(input) ? camera_name(input) : "camera";
  throw Error(fmt::format("--out: {} is a folder, but one camera is one file: --out {}{}",
                          arguments.out, (out / (name + ".yaml")).string(),
                          fs::is_directory(out) ? "" : ", after making the folder"));
}

int run_one(const CalibrateArguments& arguments) {
  check_report(arguments);
  check_file_of_one(arguments);
  check_drawing_writable(arguments.uncertainty);
  CalibrationJob job = arguments.job;
  job.input.out = arguments.out;
  job.input.other_outputs = {arguments.uncertainty, arguments.report, job.keep};
  check_replaces_nothing({arguments.out, arguments.uncertainty}, {arguments.start});
  Input used;
  CalibrationAnswer answer = run_job(job, &used);
  const bool answered = is_answer(answer.calibration.status);
  write_files(arguments, answer, std::move(used));
  std::string text =
      arguments.json
          ? calibration_json(answer)
          : calibration_summary(answer, {is_auto(arguments.job.options.model), arguments.verbose,
                                         arguments.job.options.board_warp});
  if (arguments.job.advise && !arguments.json) {
    text += wrapped("next view  ", advice_sentence(answer.advice), 11);
  }
  print_answer(text, arguments.json, answered ? arguments.out : "");
  if (answered) return kAnswer;
  say_no_answer_file(arguments.out);
  say_no_answer_file(arguments.uncertainty, "drawn");
  return kNoAnswer;
}

// Several folders are several cameras: data sets, or with --target pictures. Several inputs without
// --target are data sets too, unless all of them are files.
bool are_several_cameras(const CalibrateArguments& arguments) {
  const InputArguments& input = arguments.job.input;
  const auto is_folder = [](const auto& path) { return fs::is_directory(path); };
  if (arguments.one_camera && input.target.empty())
    throw Error(
        "--one-camera: is for folders of pictures, with --target; a data set is one camera");
  if (input.inputs.size() < 2 || arguments.one_camera) return false;
  if (input.target.empty())
    return !std::ranges::all_of(input.inputs,
                                [](const auto& path) { return fs::is_regular_file(path); });
  if (std::ranges::count_if(input.inputs, is_folder) < 2) return false;
  const auto other = std::ranges::find_if_not(input.inputs, is_folder);
  if (other != input.inputs.end())
    throw Error(
        fmt::format("{}: is no folder: several folders are several cameras, one a folder; "
                    "--one-camera takes all pictures as those of one",
                    *other));
  return true;
}

std::map<std::string, double> fixed_values(const std::vector<std::string>& texts) {
  std::map<std::string, double> values;
  for (const std::string& text : texts) {
    const std::size_t sign = text.find('=');
    const std::string number = sign == std::string::npos ? "" : text.substr(sign + 1);
    const auto value = number_of<double>(number);
    if (sign == 0 || !value) throw Error(fmt::format("--fix: must be NAME=VALUE, got {}", text));
    const std::string name = text.substr(0, sign);
    if (!values.emplace(name, *value).second)
      throw Error(fmt::format("--fix: {} is given twice", name));
  }
  return values;
}

// Applies what the user states instead of having it estimated.
void overrule(const CalibrateArguments& arguments, CalibrateOptions& options) {
  options.reject_outliers = !arguments.keep_all;
  options.fixed = fixed_values(arguments.fixed);
  if (arguments.start.empty()) return;
  if (options.start_focal_px > 0) throw Error("--start, --focal: give only one of the two");
  options.start = read_camera(arguments.start).camera;
}

// What decides the answers of several cameras, besides the data sets: all other options, and the
// content of a start.
std::string deciding_options(const CLI::App& command, const std::string& start) {
  const std::string options = given_options(
      command, {"--out", "--threads", "--resume", "--chunk", "--json", "--quiet", "--no-cache"});
  return start.empty() ? options : options + " " + digest_of_file(start);
}

int run(const CLI::App& command, const CalibrateArguments& given) {
  CalibrateArguments arguments = given;
  CalibrateOptions& options = arguments.job.options;
  overrule(arguments, options);
  arguments.job.until_px = goal_of(arguments.until);
  arguments.job.shutter = shutter_of(arguments.shutter, arguments.job.input.default_frames);
  if (arguments.near_m > 0) options.distances_m = {arguments.near_m};
  naming_options([&] { check_options(options); });  // before any work
  const bool several = are_several_cameras(arguments);
  check_usage(arguments, several);
  if (!several) return run_one(arguments);
  return calibrate_many(
      arguments.job,
      {arguments.out, arguments.json, arguments.resume, deciding_options(command, arguments.start),
       arguments.chunk.empty() ? Chunk() : chunk_of_text(arguments.chunk)});
}

// The corners, their noise, and the model.
void add_data(CLI::App& command, CalibrateArguments& arguments) {
  CalibrationJob& job = arguments.job;
  add_input(command, job.input);
  add_observations(command, job.input);
  add_no_cache(command, job.input.no_cache);
  std::vector<std::string> models = model_names();
  models.insert(models.begin(), {"auto", "weak"});
  add_option(command, "--model", job.options.model, fmt::format("{}", fmt::join(models, ", ")))
      .one_of(models)
      .text("M");
  add_positive(command, "--sigma-px", job.options.sigma_px,
               "noise of the corners per coordinate; default: each corner's own covariance if the "
               "file has them, else estimated from the residuals")
      .seldom();
  add_positive(command, "--tolerance", job.options.tolerance_px,
               "in pixels: auto takes the smallest model whose projection differs from the best "
               "one's by at most this, RMS where corners were; the standard deviations include "
               "the difference")
      .seldom();
}

void add_outputs(CLI::App& command, CalibrateArguments& arguments) {
  add_option(command, "--out", arguments.out,
             "file for the camera, written if there is an answer; for several cameras a folder, "
             "with one file each")
      .text("FILE|DIR")
      .writes_text();
  add_option(command, "--uncertainty", arguments.uncertainty,
             "drawing of the projection's uncertainty: .svg, .png")
      .text("FILE");
  add_option(command, "--report", arguments.report,
             "a page to look at: residuals, uncertainty, models, views, the next view (report.md)")
      .text("FILE.html");
  add_length(command, "--distance", arguments.near_m,
             "distance in metres at which the uncertainty is given, too, beside infinity and the "
             "corners' median")
      .seldom();
}

// What the user states instead of having it estimated.
void add_known_values(CLI::App& command, CalibrateArguments& arguments) {
  add_flag(command, "--one-camera", arguments.one_camera,
           "with --target: all folders are of one camera");
  add_flag(command, "--keep-all", arguments.keep_all,
           "reject no corner and no view, except views that repeat another")
      .seldom();
  add_option(command, "--start", arguments.start,
             "a camera to start from, instead of a search: a file of any format (tagcal convert)")
      .text("CAMERA")
      .seldom();
  add_positive(command, "--focal", arguments.job.options.start_focal_px,
               "a focal length in pixels to start from, instead of a search")
      .seldom();
  add_option(command, "--fix", arguments.fixed,
             "parameters to hold, taken as exact: f, fx, fy, cx, cy, and with --model "
             "k1, k2, .. (cx=319.5,k3=0)")
      .separated_by(',')
      .text("NAME=VALUE,..")
      .repeatable();  // the data set after it is none
}

// Which corners take part, and how they are found.
void add_corners_and_frames(CLI::App& command, CalibrateArguments& arguments) {
  CalibrationJob& job = arguments.job;
  add_flag(command, "--board-warp", job.options.board_warp,
           "print the board's terms (bend, twist, print), which every calibration from one flat "
           "board estimates; an error without one flat board")
      .seldom();
  add_flag(command, "--refine-corners", job.refine_corners,
           "fit the corners in their pictures again with the estimated lens, and calibrate again")
      .seldom();
  add_integer(command, "--select", job.select, 1,
              "calibrate from the N most informative views only, and print what each adds")
      .seldom();
  add_option(command, "--until", arguments.until,
             "of a video or bag: take frames until the projection's sd at infinity is at most PX "
             "(0.05px); default: until one adds next to nothing")
      .text("PX")
      .seldom();
  add_flag(command, "--explain", job.explains_frames,
           "of a video or bag: print why each frame is used or not")
      .seldom();
  add_option(command, "--keep", job.keep,
             "of a video or bag: folder for the frames that are used, as PNG")
      .text("DIR")
      .seldom();
  add_shutter(command, arguments.shutter);
}

void add_run(CLI::App& command, CalibrateArguments& arguments) {
  add_flag(command, "--resume", arguments.resume,
           "of several cameras, with --out: calibrate only those that have no outcome there yet; "
           "several processes can share the folder")
      .seldom();
  add_option(command, "--chunk", arguments.chunk,
             "of several cameras, with --resume: every N-th one from the K-th on, as one of N jobs")
      .text("K/N")
      .seldom();
  add_flag(command, "--advise", arguments.job.advise,
           "print the next view that would improve the answer most, and by how much");
  add_flag(command, "--verbose", arguments.verbose,
           "also print why each model was taken or not, all rejected corners, and times");
  add_flag(command, "--json", arguments.json,
           "one JSON object on stdout; an array for several cameras");
  add_threads(command, arguments.job.threads)
      .description("cameras, or pictures of one, to process in parallel; 0: one per core");
}

}  // namespace

Command add_calibrate(CLI::App& app) {
  CLI::App* command = add_command(app, "calibrate", "the camera and its standard deviations");
  const auto arguments = std::make_shared<CalibrateArguments>();
  for (const auto add : {add_data, add_outputs, add_known_values, add_corners_and_frames, add_run})
    add(*command, *arguments);
  add_footer(*command,
             "Example: tagcal calibrate desk --observations corners.csv --out camera.yaml\n"
             "         tagcal calibrate --target board.yaml photos/*.jpg --json\n"
             "         tagcal calibrate --target board.yaml left right --out cameras");
  return {command, [command, arguments] { return run(*command, *arguments); }};
}

}  // namespace tagcal::tools
