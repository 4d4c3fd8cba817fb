#include "job/calibration_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/frame_choice.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// The folders of the pictures, view by view, if they are in several: the pictures of each are
// compared with the others.
std::vector<std::string> sources_of(const Input& input) {
  std::vector<std::string> folders;
  for (const View& view : input.dataset.views) {
    const auto file = input.files.find(view.image);
    if (file == input.files.end()) return {};
    folders.push_back(file->second.parent_path().string());
  }
  if (std::set<std::string>(folders.begin(), folders.end()).size() < 2) return {};
  return folders;
}

Calibration calibrate_input(const Input& input, CalibrateOptions options, bool by_times) {
  options.sources = sources_of(input);
  if (by_times) options.times_s = film_times(input.dataset.views, input.times_s);
  return calibrate(input.dataset, options);
}

// A rolling shutter displaces the corners of frames that move alike in the same way, so that it
// looks like another lens: only their motion in time tells.
Calibration calibrate_input(const CalibrationJob& job, Input& input,
                            const CalibrateOptions& options) {
  const bool is_automatic = job.shutter == Shutter::automatic && has_times(input);
  if (!is_automatic) return calibrate_input(input, options, job.shutter == Shutter::rolling);
  std::optional<Input> near = with_neighbours(input, job.threads, job.shows_progress);
  Calibration timed = calibrate_input(near ? *near : input, options, true);
  if (timed.readout && timed.readout->is_seen) {
    if (near) input = *std::move(near);
    return timed;
  }
  if (near) return calibrate_input(input, options, false);
  forget_readout(timed);
  return timed;
}

// Calibrates the views that are there now. The times are those of all calibrations.
void calibrate_once_more(const CalibrationJob& job, Input& input, const CalibrateOptions& options,
                         Calibration& calibration) {
  const CalibrateSeconds before = calibration.seconds;
  calibration = calibrate_input(job, input, options);
  CalibrateSeconds& seconds = calibration.seconds;
  seconds.start += before.start;
  seconds.solve += before.solve;
  seconds.covariance += before.covariance;
  seconds.total += before.total;
}

// Refines the corners with the lens of the first calibration, and calibrates again.
void calibrate_again(const CalibrationJob& job, const CalibrateOptions& options, Input& input,
                     CalibrationAnswer& answer) {
  Calibration& calibration = answer.calibration;
  const bool has_lens = is_answer(calibration.status) && calibration.model != "weak";
  if (!has_lens) {
    input.warnings.emplace_back("the corners are not refined: the first calibration gave no lens");
    return;
  }
  const Stopwatch watch;
  refine_views(input, *calibration.camera, job.threads, job.shows_progress);
  answer.seconds.refine = watch.seconds();
  std::optional<Progress> progress;
  if (job.shows_progress) progress.emplace("calibrating again");
  calibrate_once_more(job, input, options, calibration);
}

// Keeps the most informative views only, and calibrates again.
std::optional<ViewSelection> select_and_calibrate(const CalibrationJob& job,
                                                  const CalibrateOptions& options, Input& input,
                                                  Calibration& calibration) {
  ViewSelection selection = select_views(input.dataset, calibration, job.select);
  if (selection.views.empty()) {
    input.warnings.emplace_back(
        "--select: no view is selected, because the calibration of all views has no covariance");
    return std::nullopt;
  }
  std::set<std::size_t> kept;
  for (const SelectedView& view : selection.views) kept.insert(view.view);
  std::vector<View> views;
  for (const std::size_t view : kept) views.push_back(std::move(input.dataset.views[view]));
  input.dataset.views = std::move(views);
  calibrate_once_more(job, input, options, calibration);
  return selection;
}

// Throws Error for synthetic pictures whose own truth says that no model contains their camera.
void check_truth_has_one_lens(const Input& input) {
  const std::optional<Truth>& truth = input.dataset.truth;
  if (!truth) return;
  const auto* parallel = std::get_if<Parallel>(&truth->camera.lens);
  if (parallel && parallel->oblique())
    throw Error(input.name + ": truth.yaml: camera: is an oblique projection, which no model has");
  if (!truth->lenses.empty())
    throw Error(input.name +
                ": truth.yaml: poses: each view has its own lens, calibrate finds one");
}

// "none of 13 pictures shows the target"
std::string too_few_text(const Input& input) {
  const std::size_t count = input.dataset.views.size();
  if (const int corners = num_corners(input.dataset.views); corners > 0)
    return fmt::format("the pictures show {} corners in all, a calibration needs {}", corners,
                       kFewestCorners);
  return count == 1 ? "the picture does not show the target"
                    : fmt::format("none of {} pictures shows the target", count);
}

// The first mistake that moves corners, else the first. Precondition: there is one.
const TargetMistake& most_telling(const std::vector<TargetMistake>& mistakes) {
  const auto moving = std::ranges::find_if(mistakes, &TargetMistake::moves_corners);
  return moving == mistakes.end() ? mistakes.front() : *moving;
}

// The answer, if the corners allow none: too few, or numbered by a wrong target file.
std::optional<Calibration> refusal_of(const Input& input) {
  Calibration refused;
  const std::optional<Finding> wrong = wrong_target(input.mistakes);
  if (num_corners(input.dataset.views) < kFewestCorners) {
    std::string reason = too_few_text(input);
    const bool is_explained = !input.mistakes.empty();
    if (is_explained)
      reason += ": " + most_telling(input.mistakes).text();
    else
      reason += "; tagcal detect --explain says what is in a picture";
    add(refused.findings, code::degenerate, reason);
  } else if (wrong) {
    refused.findings.push_back(*wrong);
  } else {
    return std::nullopt;
  }
  refused.status = judge(refused.findings);
  return refused;
}

// True for the warning that is the reason of a refusal.
bool is_said(const Calibration& calibration, const std::string& warning) {
  const std::size_t colon = warning.find(": ");
  return !is_answer(calibration.status) && warning.starts_with("the pictures and the target") &&
         std::ranges::any_of(calibration.findings, [&](const Finding& finding) {
           return finding.sentence.ends_with(warning.substr(colon + 2));
         });
}

std::string fate_text(FrameFate fate, double speed_px) {
  switch (fate) {
    case FrameFate::used:
      return "used";
    case FrameFate::no_board:
      return "no board";
    case FrameFate::fast:
      return fmt::format("fast, {:.0f} px/s", speed_px);
    case FrameFate::no_pose:
      return "no pose under the lens of the others";
    case FrameFate::nothing:
      return "adds next to nothing";
  }
  return "";
}

void count(FrameFate fate, FrameTally& tally) {
  tally.with_board += fate != FrameFate::no_board;
  tally.fast += fate == FrameFate::fast;
  tally.no_pose += fate == FrameFate::no_pose;
  tally.nothing += fate == FrameFate::nothing;
  tally.used += fate == FrameFate::used;
}

void keep_pictures(const std::string& place, const Input& input) {
  OutputFolder folder(place, OutputFolder::Taken::by_any_folder);
  for (const View& view : input.dataset.views)
    write_picture(folder.path() / (view.image + ".png"), read_picture(input.files.at(view.image)));
  folder.publish();
  say_wrote(place);
}

// Throws Error if the job asks for something of chosen frames, but the input has none.
void check_frame_options(const CalibrationJob& job, const Input& input) {
  if (input.frames) return;
  const char* const option = !job.keep.empty()     ? "--keep"
                             : job.until_px > 0    ? "--until"
                             : job.explains_frames ? "--explain"
                                                   : nullptr;
  if (option)
    throw Error(
        fmt::format("{}: belongs to the frames that are chosen of one video or bag, with "
                    "--frames auto",
                    option));
}

// "1500 frames: 812 looked at, 810 with board, 40 fast, 670 add nothing, 100 used"
std::string tally_text(const FrameTally& tally) {
  std::string text = fmt::format("{} frames: {} looked at, {} with board", tally.all,
                                 tally.looked_at, tally.with_board);
  if (tally.fast > 0) text += fmt::format(", {} fast", tally.fast);
  if (tally.no_pose > 0) text += fmt::format(", {} without a pose", tally.no_pose);
  return text + fmt::format(", {} add nothing, {} used", tally.nothing, tally.used);
}

// Keeps the views of the frames that add most (choose_frames), counts what became of the others,
// says so, and fills the folder `keep`, if there is one.
void take_chosen_frames(const CalibrationJob& job, const CalibrateOptions& options, Input& input) {
  std::vector<double> times_s;
  for (const View& view : input.dataset.views) times_s.push_back(input.times_s.at(view.image));
  const FrameSelection chosen = choose_frames(input.dataset, times_s, options, job.until_px);
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    count(chosen.fates[i], *input.frames);
    if (job.explains_frames)
      print_to_stderr("{}: {}\n", input.dataset.views[i].image,
                      fate_text(chosen.fates[i], chosen.speeds_px[i]));
  }
  std::vector<View> views;
  std::vector<std::vector<UnfittedTag>> unfitted;
  for (const std::size_t i : chosen.used) {
    views.push_back(std::move(input.dataset.views[i]));
    if (i < input.unfitted.size()) unfitted.push_back(std::move(input.unfitted[i]));
  }
  input.dataset.views = std::move(views);
  input.unfitted = std::move(unfitted);
  print_note("{}\n", tally_text(*input.frames));
  if (!job.keep.empty()) keep_pictures(job.keep, input);
}

Calibration calibrate_or_refuse(const CalibrationJob& job, const CalibrateOptions& options,
                                Input& input) {
  if (auto refused = refusal_of(input)) return *std::move(refused);
  if (input.frames) naming_options([&] { take_chosen_frames(job, options, input); });
  return naming_options([&] { return calibrate_input(job, input, options); });
}

}  // namespace

CalibrationAnswer run_job(const CalibrationJob& job, Input* used) {
  const Stopwatch watch;
  Input input = read_input(job.input);
  check_frame_options(job, input);
  check_truth_has_one_lens(input);
  check_times(job.shutter, has_times(input));
  if (job.options.start) check_image_size(job.options.start->image_size, "--start", input);
  if (input.observations.empty())
    find_views(input, job.threads, job.shows_progress);
  else
    need_views(input, job.threads);
  CalibrationAnswer answer;
  answer.seconds.read = watch.seconds();
  std::optional<Progress> progress;
  if (job.shows_progress) progress.emplace("calibrating");
  CalibrateOptions options = job.options;
  options.num_threads = static_cast<std::size_t>(job.threads);
  answer.calibration = calibrate_or_refuse(job, options, input);
  answer.frames = input.frames;
  if (job.select > 0)
    answer.selection = select_and_calibrate(job, options, input, answer.calibration);
  progress.reset();
  if (job.refine_corners) calibrate_again(job, options, input, answer);
  std::vector<Finding> findings;
  for (const std::string& warning : input.warnings)
    if (!is_said(answer.calibration, warning)) add(findings, code::input, warning);
  auto& all = answer.calibration.findings;
  all.insert(all.begin(), findings.begin(), findings.end());
  answer.corner_error_px = input.corner_error_px;
  if (job.advise) answer.advice = advise(input.dataset, answer.calibration);
  answer.seconds.total = watch.seconds();
  if (used) *used = std::move(input);
  return answer;
}

}  // namespace tagcal::tools
