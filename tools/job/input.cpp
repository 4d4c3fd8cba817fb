#include "job/input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "job/arguments.hpp"
#include "job/messages.hpp"
#include "job/outputs.hpp"
#include "job/picture_files.hpp"
#include "job/warning_groups.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, Refinement> kRefinements = {
    {"stock", Refinement::stock}, {"edges", Refinement::edges}, {"fit", Refinement::fit}};

// The times of frames of videos and bags. Those of one sequence follow one another.
void set_times(Input& input) {
  fs::path read;
  ImageSequence sequence;
  for (const auto& [name, file] : input.files) {
    const auto frame = frame_of(file);
    if (!frame) continue;
    if (frame->sequence != read) sequence = read_sequence(frame->sequence);
    read = frame->sequence;
    if (frame->frame < sequence.times_s.size())
      input.times_s[name] = sequence.start_s + sequence.times_s[frame->frame];
  }
}

// A picture is named by its file name, or by the given path if two pictures share a name. Throws
// Error for a name that no file of corners can hold, before all the work.
void set_images(const std::vector<fs::path>& files, Input& input) {
  std::map<std::string, int> uses;
  for (const fs::path& file : files) ++uses[picture_name(file)];
  std::optional<SequenceFrame> before;
  for (const fs::path& file : files) {
    std::string name = picture_name(file);
    if (uses[name] > 1) name = file.string();
    if (!is_image_name(name))
      throw Error(fmt::format("{}: the name of a picture must be one line", file.string()));
    auto frame = frame_of(file);
    const bool follows = frame && before && frame->sequence == before->sequence;
    before = std::move(frame);
    input.images.push_back({name, [file] { return read_image(file); }, follows});
    input.files[name] = file;
  }
  set_times(input);
}

Board read_board(const InputArguments& arguments, Input& input) {
  std::optional<double> size;
  if (arguments.tag_size_m > 0) size = arguments.tag_size_m;
  return read_target(arguments.target, {}, &input.warnings, size);
}

Input read_pictures(const InputArguments& arguments, Exclusion& exclusion) {
  if (!arguments.observations.empty()) {
    throw Error(
        "--observations: needs a DATASET; with --target leave it out: the corners are found in the "
        "pictures");
  }
  Input input;
  input.name = arguments.target.empty() ? arguments.inputs.front() : arguments.target;
  if (!arguments.target.empty()) {
    input.texts.emplace_back(arguments.target);
    input.dataset.boards.push_back({read_board(arguments, input), {}});
  }
  std::vector<fs::path> files = picture_files(
      arguments.inputs,
      frame_choice(arguments.frames.empty() ? arguments.default_frames : arguments.frames),
      &input.frames);
  std::erase_if(files, [&](const fs::path& file) { return exclusion.excludes(file); });
  if (files.empty()) throw Error("--exclude: leaves no picture");
  std::vector<ImageHeader> headers;
  const std::vector<std::string> unreadable = remove_unreadable(files, headers);
  leave_out(unreadable, arguments.strict, files.empty(), input.warnings);
  input.dataset.image_size = common_size(files, headers);
  warn_of_turns(files, headers, input.warnings);
  input.sized_by = files.front().string();
  set_images(files, input);
  return input;
}

// Throws Error, with what to do, if the input is not one folder of a data set.
void check_dataset_folder(const InputArguments& arguments) {
  const std::string& folder = arguments.inputs.front();
  const fs::path beside = fs::path(folder) / "target.yaml";
  const std::string advice =
      arguments.takes_pictures
          ? fmt::format(" (pictures need their board, --target {})",
                        fs::exists(beside) ? beside.lexically_normal().string() : "T.yaml")
          : "";
  if (arguments.inputs.size() > 1) {
    throw Error(fmt::format("{}: only one DATASET is possible{}", arguments.inputs[1], advice));
  }
  if (fs::is_regular_file(folder)) {
    throw Error(
        fmt::format("{}: must be a folder with dataset.yaml, got a file{}", folder, advice));
  }
  if (!fs::exists(fs::path(folder) / "dataset.yaml") && fs::is_directory(folder)) {
    if (!list_pictures(folder).empty())
      throw Error(fmt::format("{}: has pictures, but no dataset.yaml{}", folder, advice));
    const std::vector<fs::path> unread = files_not_read(folder);
    if (!unread.empty()) read_image_size(unread.front());  // says what to do
  }
}

Input read_folder(const InputArguments& arguments, Exclusion& exclusion) {
  check_dataset_folder(arguments);
  check_dataset_options(arguments);
  const std::string& folder = arguments.inputs.front();
  DatasetFolder read =
      read_dataset(folder, [&](const fs::path& file) { return exclusion.excludes(file); });
  Input input;
  input.name = input.sized_by = folder;
  input.dataset = std::move(read.dataset);
  input.warnings = std::move(read.warnings);
  input.observations = read.observations.string();
  input.of_dataset = arguments.observations.empty();
  input.texts = std::move(read.texts);
  input.times_s = std::move(read.times_s);
  leave_out(read.unreadable, arguments.strict, read.images.empty(), input.warnings);
  set_images(read.images, input);
  if (!arguments.observations.empty()) {
    input.observations = arguments.observations;
    input.texts.emplace_back(arguments.observations);
    input.dataset.views = read_observations(arguments.observations, input.dataset.boards,
                                            &input.warnings, &input.times_s);
  }
  std::erase_if(input.dataset.views,
                [&](const View& view) { return exclusion.excludes(view.image); });
  if (!arguments.excluded.empty() && input.images.empty() && input.dataset.views.empty())
    throw Error("--exclude: leaves no picture");
  return input;
}

// Pictures that are left out are not replaced either.
void check_outputs(const InputArguments& arguments, const Input& input) {
  std::vector<fs::path> outputs(arguments.other_outputs.begin(), arguments.other_outputs.end());
  outputs.emplace_back(arguments.out);
  std::vector<fs::path> inputs = input.texts;
  inputs.insert(inputs.end(), arguments.inputs.begin(), arguments.inputs.end());
  for (const auto& [name, file] : input.files) inputs.push_back(file);
  for (const std::string& argument : arguments.inputs)
    if (is_sequence_name(argument))
      for (const fs::path& file : files_of_sequence(argument)) inputs.push_back(file);
  check_replaces_nothing(outputs, inputs);
}

}  // namespace

void leave_out(const std::vector<std::string>& unreadable, bool strict, bool none_left,
               std::vector<std::string>& warnings) {
  if (unreadable.empty()) return;
  if (strict) throw Error(unreadable.front());
  if (none_left) {
    throw Error(unreadable.size() == 1 ? unreadable.front()
                                       : fmt::format("none of {} pictures can be read: {}",
                                                     unreadable.size(), unreadable.front()));
  }
  for (const std::string& message : unreadable)
    warnings.push_back(message + "; the picture is left out");
}

void warn_of_unused(const Exclusion& exclusion, std::vector<std::string>& warnings) {
  for (const std::string& pattern : exclusion.unused())
    warnings.push_back(fmt::format("--exclude: {} is the name of no picture", pattern));
}

void check_dataset_options(const InputArguments& arguments) {
  const std::string& name = arguments.inputs.front();
  if (!arguments.frames.empty())
    throw Error(
        fmt::format("--frames: belongs to videos and bags, {} is a data set of pictures: "
                    "leave it out, or leave pictures out with --exclude",
                    name));
  if (arguments.tag_size_m > 0) throw Error("--tag-size: needs --target, a field layout of WPILib");
}

std::optional<Refinement> refinement_of(const InputArguments& arguments) {
  if (arguments.refinement.empty()) return std::nullopt;
  return kRefinements.at(arguments.refinement);
}

void choose_views(Input& input, const std::vector<std::string>& names) {
  std::set<std::string> known;
  for (const ImageSource& source : input.images) known.insert(source.name);
  for (const View& view : input.dataset.views) known.insert(view.image);
  for (const std::string& name : names)
    if (!known.contains(name)) throw Error(fmt::format("--view: {} has no {}", input.name, name));
  const auto is_other = [&](const std::string& name) {
    return std::ranges::count(names, name) == 0;
  };
  std::erase_if(input.images, [&](const auto& source) { return is_other(source.name); });
  std::erase_if(input.dataset.views, [&](const auto& view) { return is_other(view.image); });
}

std::optional<double> time_of(const Input& input, const std::string& image) {
  const auto time = input.times_s.find(image);
  return time == input.times_s.end() ? std::nullopt : std::optional(time->second);
}

Input input_of(const std::string& name, const Dataset& dataset,
               const std::vector<fs::path>& pictures) {
  Input input;
  input.name = input.sized_by = name;
  input.dataset = dataset;
  set_images(pictures, input);
  return input;
}

void add_input(CLI::App& command, InputArguments& arguments) {
  add_option(command, "DATASET|IMAGE", arguments.inputs,
             "a folder with dataset.yaml, or (with --target) pictures: files, folders, patterns "
             "('photos/*.png') or @LIST, a file with one of these a line")
      .required();
  add_option(command, "--target", arguments.target, "the board in the pictures: a target file")
      .text("T.yaml");
  add_picture_options(command, arguments);
}

void add_picture_options(CLI::App& command, InputArguments& arguments) {
  arguments.takes_pictures = true;
  add_length(command, "--tag-size", arguments.tag_size_m,
             "side of the tags in metres, black edge to black edge, if --target is a field layout "
             "of WPILib, which does not state it (0.1651)")
      .seldom();
  add_option(command, "--refinement", arguments.refinement,
             "how corners are located in pictures: fit (of the whole printed tag, with "
             "covariances; the default), edges (of its four sides) or stock (AprilTag's own)")
      .one_of({"fit", "edges", "stock"})
      .text("R")
      .seldom();
  add_option(command, "--exclude", arguments.excluded,
             "a picture to leave out, or a pattern ('blurred*')")
      .text("NAME")
      .repeatable();
  add_option(command, "--frames", arguments.frames,
             "of videos and bags: auto (one for each step of the motion; calibrate takes those "
             "that add most), evenly (300), all, every:N, or a text file with their numbers")
      .text("FRAMES")
      .seldom();
  add_flag(command, "--strict", arguments.strict,
           "a picture that cannot be read ends the run; default: it is left out with a warning")
      .seldom();
}

void add_no_cache(CLI::App& command, bool& no_cache) {
  add_flag(command, "--no-cache", no_cache,
           "detect all corners again, and keep none beside --out (FILE.corners-cache)")
      .seldom();
}

void add_observations(CLI::App& command, InputArguments& arguments) {
  add_option(command, "--observations", arguments.observations,
             "corners of tagcal detect, instead of the data set's")
      .text("CSV")
      .reads_text();
}

Input read_input(const InputArguments& arguments, Exclusion* of_several) {
  if (!arguments.observations.empty() && !arguments.refinement.empty())
    throw Error("--refinement: belongs to corners found in pictures, not to --observations");
  const bool is_dataset = arguments.target.empty() && arguments.family.empty();
  Exclusion own(arguments.excluded);
  Exclusion& exclusion = of_several ? *of_several : own;
  Input input =
      is_dataset ? read_folder(arguments, exclusion) : read_pictures(arguments, exclusion);
  if (!of_several) warn_of_unused(own, input.warnings);
  input.refinement = refinement_of(arguments);
  input.strict = arguments.strict;
  check_outputs(arguments, input);
  if (!arguments.no_cache && !arguments.out.empty()) input.cache = corner_cache_of(arguments.out);
  return input;
}

fs::path corner_cache_of(const fs::path& out) {
  if (is_stream(out)) return {};  // nothing can stand beside it
  fs::path cache = out;
  return cache += ".corners-cache";
}

void check_image_size(const ImageSize& size, const std::string& file, const Input& input) {
  const ImageSize& expected = input.dataset.image_size;
  if (size == expected) return;
  throw Error(fmt::format(
      "{}: image size must be {}x{} as in {}, got {}x{}; if these pictures were scaled or cut, "
      "convert the camera with --resize or --crop",
      file, expected.width, expected.height, input.sized_by, size.width, size.height));
}

void leave_out_unreadable(Input& input, const std::vector<std::string>& unreadable) {
  std::vector<std::string> messages;
  std::vector<ImageSource> images;
  for (std::size_t i = 0; i < unreadable.size(); ++i) {
    if (unreadable[i].empty())
      images.push_back(std::move(input.images[i]));
    else
      messages.push_back(unreadable[i]);
  }
  input.images = std::move(images);
  leave_out(messages, input.strict, input.images.empty(), input.warnings);
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : in_groups(warnings))
    print_to_stderr("tagcal: warning: {}\n", warning);
}

void check_different(const RigDataset& rig) {
  const auto same = [](const View& a, const View& b) {
    return std::ranges::equal(a.observations, b.observations,
                              [](const Observation& x, const Observation& y) {
                                return x.id == y.id && x.pixel == y.pixel;
                              });
  };
  std::multimap<std::pair<double, double>, std::pair<const RigCamera*, const View*>> seen;
  for (const RigCamera& camera : rig.cameras)
    for (const View& view : camera.data.views) {
      if (view.observations.empty()) continue;
      const Eigen::Vector2d& pixel = view.observations.front().pixel;
      const std::pair key(pixel.x(), pixel.y());
      const auto [first, last] = seen.equal_range(key);
      for (auto it = first; it != last; ++it) {
        const auto& [other, its_view] = it->second;
        if (other != &camera && same(*its_view, view))
          throw Error(
              fmt::format("{} and {}: {} and {} are the same picture: each camera needs its "
                          "own pictures",
                          other->name, camera.name, its_view->image, view.image));
      }
      seen.emplace(key, std::pair(&camera, &view));
    }
}

}  // namespace tagcal::tools
