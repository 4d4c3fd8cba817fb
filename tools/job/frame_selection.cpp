#include "job/calibration_job.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/frame_choice.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

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

}  // namespace

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

std::string tally_text(const FrameTally& tally) {
  std::string text = fmt::format("{} frames: {} looked at, {} with board", tally.all,
                                 tally.looked_at, tally.with_board);
  if (tally.fast > 0) text += fmt::format(", {} fast", tally.fast);
  if (tally.no_pose > 0) text += fmt::format(", {} without a pose", tally.no_pose);
  return text + fmt::format(", {} add nothing, {} used", tally.nothing, tally.used);
}

}  // namespace tagcal::tools
