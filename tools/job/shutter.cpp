#include "job/shutter.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "job/find_corners.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/io/sequence_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// The frames of the views, and those before and behind them.
std::set<fs::path> frames_around(const Input& input) {
  std::set<fs::path> frames;
  std::map<fs::path, std::size_t> counts;  // of frames, by sequence
  for (const View& view : input.dataset.views) {
    const auto [sequence, frame] = *frame_of(input.files.at(view.image));
    const auto known = counts.find(sequence);
    const std::size_t count =
        known != counts.end()
            ? known->second
            : counts.emplace(sequence, read_sequence(sequence).times_s.size()).first->second;
    for (std::size_t i = frame - (frame > 0); i <= frame + 1 && i < count; ++i)
      frames.insert(frame_path(sequence, i));
  }
  return frames;
}

Input input_of_frames(const std::set<fs::path>& frames, const Input& like) {
  Dataset dataset{like.dataset.image_size, like.dataset.boards, {}, {}};
  Input input = input_of(like.name, dataset, {frames.begin(), frames.end()});
  input.sized_by = like.sized_by;
  input.strict = like.strict;
  input.refinement = like.refinement;
  return input;
}

}  // namespace

Option add_shutter(CLI::App& command, std::string& shutter) {
  return add_option(command, "--shutter", shutter,
                    "of a video or bag: rolling estimates how long the rows take, from all frames; "
                    "auto (the default) looks for that in the neighbours of the frames, global "
                    "does not")
      .one_of({"auto", "rolling", "global"})
      .text("S")
      .seldom();
}

Shutter shutter_of(const std::string& text, std::string& default_frames) {
  if (text == "rolling") default_frames = "all";
  return text == "rolling"  ? Shutter::rolling
         : text == "global" ? Shutter::global
                            : Shutter::automatic;
}

bool has_times(const Input& input) {
  const auto is_timed = [&](const std::string& name) { return input.times_s.contains(name); };
  return input.images.empty() ? !input.dataset.views.empty() &&
                                    std::ranges::all_of(input.dataset.views, is_timed, &View::image)
                              : std::ranges::all_of(input.images, is_timed, &ImageSource::name);
}

void check_times(Shutter shutter, bool has_times) {
  if (shutter == Shutter::rolling && !has_times)
    throw Error(
        "--shutter rolling: needs a time for each picture, as frames of a video or bag and "
        "observations with the column time_s have");
}

std::vector<double> film_times(const std::vector<View>& views,
                               const std::map<std::string, double>& times_s) {
  constexpr double kDay = 86400;  // numeric: longer than a video
  std::map<std::string, double> days;
  std::vector<double> result;
  for (const View& view : views) {
    const std::size_t at = view.image.rfind('@');
    const std::string sequence = at == std::string::npos ? "" : view.image.substr(0, at);
    const double day =
        days.try_emplace(sequence, kDay * static_cast<double>(days.size())).first->second;
    result.push_back(day + times_s.at(view.image));
  }
  return result;
}

std::optional<Input> with_neighbours(const Input& input, int threads, bool shows_progress) {
  const auto is_frame = [&](const View& view) {
    const auto file = input.files.find(view.image);
    return file != input.files.end() && frame_of(file->second);
  };
  if (!std::ranges::all_of(input.dataset.views, is_frame)) return std::nullopt;
  std::set<fs::path> frames = frames_around(input), missing = frames;
  std::map<fs::path, View> views;
  for (const View& view : input.dataset.views) {
    missing.erase(input.files.at(view.image));
    views[input.files.at(view.image)] = view;
  }
  if (missing.empty()) return std::nullopt;
  Input near = input_of_frames(missing, input);
  find_views(near, threads, shows_progress);
  for (View& view : near.dataset.views) views[near.files.at(view.image)] = std::move(view);
  Input all = input_of_frames(frames, input);
  for (const auto& [name, file] : all.files) {
    const auto view = views.find(file);
    if (view == views.end()) continue;
    view->second.image = name;
    all.dataset.views.push_back(std::move(view->second));
  }
  all.frames = input.frames;
  all.mistakes = input.mistakes;
  all.warnings = input.warnings;
  all.corner_error_px = input.corner_error_px;
  return all;
}

void forget_readout(Calibration& calibration) {
  calibration.readout.reset();
  forget_readout(calibration.findings);
}

void forget_readout(std::vector<Finding>& findings) {
  std::erase_if(findings, [](const Finding& finding) {
    return finding.code == code::readout_not_observable.name;
  });
}

}  // namespace tagcal::tools
