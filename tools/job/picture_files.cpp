#include "job/picture_files.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <glob.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "job/frame_motion.hpp"
#include "job/messages.hpp"
#include "job/plain_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 5;      // odd pictures in a message
constexpr std::size_t kEvenly = SIZE_MAX;  // FrameChoice::every of up to kFewestWalked frames

bool is_pattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

std::vector<fs::path> matches_of(const std::string& pattern) {
  glob_t found{};
  const int result = ::glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<fs::path> files;
  std::error_code unknown;  // a loop of links is found out when it is read
  for (std::size_t i = 0; result == 0 && i < found.gl_pathc; ++i)
    if (!fs::is_directory(found.gl_pathv[i], unknown)) files.emplace_back(found.gl_pathv[i]);
  ::globfree(&found);
  if (files.empty()) throw Error(fmt::format("{}: matches no file", pattern));
  return files;
}

// Endings of pictures, videos and bags that are not read, which people have beside pictures: they
// are opened for the message that names them and says what to do.
bool is_unread_kind(const fs::path& file) {
  constexpr std::string_view kKinds[] = {".gif", ".jp2", ".jxl", ".cr3", ".raf"};
  if (is_sequence_name(file.filename().string())) return true;
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(kKinds, ending) != std::end(kKinds);
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files = list_pictures(folder);
  for (const fs::path& file : files_not_read(folder)) files.push_back(file);
  std::ranges::sort(files);
  if (!files.empty()) return files;
  const bool is_data_set = fs::exists(folder / "dataset.yaml");
  throw Error(fmt::format(
      "{}: {}", folder.string(),
      is_data_set
          ? "is a data set: name its folder of pictures, or leave out --target and --family"
          : "has no pictures (png, jpg, tif, bmp, webp, heic, avif, pgm, ppm), videos or bags"));
}

std::vector<fs::path> files_of(const std::string& argument) {
  if (argument == "-") return {piped_video()};
  if (fs::is_directory(argument)) return pictures_in(argument);
  if (is_pattern(argument) && !fs::exists(argument)) return matches_of(argument);
  const bool is_topic =
      is_sequence_name(argument) && fs::exists(files_of_sequence(argument).front());
  if (!fs::exists(argument) && !frame_of(argument) && !is_topic)
    throw Error(fmt::format("{}: no such file", argument));
  return {argument};
}

// A line of a list as an argument. Errors name the list and the line.
std::vector<fs::path> files_of_line(const std::string& line, const fs::path& list,
                                    std::size_t number) {
  try {
    const fs::path beside = list.parent_path() / line;
    const bool is_here = fs::exists(line) || (is_pattern(line) && !fs::exists(beside) &&
                                              !is_pattern(beside.parent_path().string()) &&
                                              fs::is_directory(fs::path(line).parent_path()));
    if (is_here || fs::path(line).is_absolute()) return files_of(line);
    return files_of(beside.string());
  } catch (const Error& error) {
    throw Error(fmt::format("{}: line {}: {}", list.string(), number, error.what()));
  }
}

// The lines of a file but for empty ones and comments, with their numbers.
void for_each_entry(const fs::path& file,
                    const std::function<void(const std::string& line, std::size_t number)>& take) {
  for_each_line(read_plain_text(file), [&](std::string_view line, std::size_t number) {
    line = trimmed(line, " \t\r");
    if (!line.empty() && !line.starts_with('#')) take(std::string(line), number);
  });
}

std::vector<fs::path> files_of_list(const fs::path& list) {
  std::vector<fs::path> files;
  for_each_entry(list, [&](const std::string& line, std::size_t number) {
    const std::vector<fs::path> more = files_of_line(line, list, number);
    files.insert(files.end(), more.begin(), more.end());
  });
  if (files.empty()) throw Error(fmt::format("{}: names no pictures", list.string()));
  return files;
}

std::vector<std::size_t> chosen_frames(const fs::path& file, std::size_t num_frames,
                                       const FrameChoice& choice) {
  if (!choice.these.empty()) {
    if (choice.these.back() >= num_frames)
      throw Error(fmt::format("{}: has {} frames, there is none of number {}", file.string(),
                              num_frames, choice.these.back()));
    return choice.these;
  }
  if (choice.is_auto()) return walked_frames(file, num_frames);
  if (choice.every == kEvenly) return internal::spread_indices(num_frames, kFewestWalked);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < num_frames; i += choice.every) chosen.push_back(i);
  return chosen;
}

// Videos and bags replaced by the frames of them that are chosen.
std::vector<fs::path> with_frames(const std::vector<fs::path>& files, const FrameChoice& choice,
                                  std::optional<FrameTally>* tally) {
  const bool has_pictures = std::ranges::any_of(files, is_picture_name);
  std::vector<fs::path> all;
  for (const fs::path& file : files) {
    if (!is_sequence_name(file) || has_pictures) {
      all.push_back(file);
      continue;
    }
    const ImageSequence sequence = read_sequence(file);
    const std::vector<std::size_t> chosen = chosen_frames(file, sequence.times_s.size(), choice);
    for (const std::size_t i : chosen) all.push_back(frame_path(file, i));
    if (tally && choice.is_auto() && files.size() == 1)
      *tally = FrameTally{.all = sequence.times_s.size(), .looked_at = chosen.size()};
    if (is_quiet()) continue;
    if (chosen.size() < sequence.times_s.size())
      hold_note(fmt::format("{}: {} of {} frames are taken{}", file.string(), chosen.size(),
                            sequence.times_s.size(),
                            choice.every == kEvenly ? ", evenly spread" : " (--frames)"));
    if (sequence.is_interlaced)
      hold_note(
          fmt::format("{}: is interlaced, its odd and even rows are of different "
                      "times: hold the board still, or record progressively",
                      file.string()));
    if (sequence.is_cut_off)
      hold_note(fmt::format("{}: is cut off or damaged: the frames until there are taken",
                            file.string()));
  }
  return all;
}

std::string size_text(const ImageSize& size) {
  return fmt::format("{}x{}", size.width, size.height);
}

// "b.png is 480x640 (turned by 90 degrees?)"
std::string odd_text(const fs::path& file, const ImageSize& size, const ImageSize& common) {
  const bool turned = size.width == common.height && size.height == common.width;
  return fmt::format("{} is {}{}", file.string(), size_text(size),
                     turned ? " (turned by 90 degrees)" : "");
}

constexpr std::string_view kSameTurn =
    "write the same Exif orientation into all of them (exiftool -n -Orientation=1)";

// The first picture that is turned otherwise than the first of all.
std::optional<std::size_t> other_turn(const std::vector<ImageHeader>& headers) {
  for (std::size_t i = 0; i < headers.size(); ++i)
    if (headers[i].orientation != headers.front().orientation) return i;
  return std::nullopt;
}

}  // namespace

std::vector<fs::path> files_not_read(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;  // the folder has gone
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_unread_kind(entry.path()) && entry.is_regular_file(error)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

FrameChoice frame_choice(const std::string& text) {
  if (text.empty() || text == "auto") return {};
  if (text == "evenly") return {kEvenly, {}};
  if (text == "all") return {1, {}};
  constexpr std::string_view kEvery = "every:";
  if (text.starts_with(kEvery)) {
    const std::string count = text.substr(kEvery.size());
    const auto every = number_of<std::size_t>(count);
    if (!every || *every == 0)
      throw Error(fmt::format("--frames: every:N needs a number from 1 on, got {}", text));
    return {*every, {}};
  }
  if (!fs::exists(text))
    throw Error(
        fmt::format("--frames: must be auto, evenly, all, every:N or a file, got {}", text));
  FrameChoice choice;
  for_each_entry(text, [&](const std::string& line, std::size_t number) {
    const auto frame = number_of<std::size_t>(line);
    if (!frame)
      throw Error(
          fmt::format("{}: line {}: must be the number of a frame, got {}", text, number, line));
    choice.these.push_back(*frame);
  });
  if (choice.these.empty()) throw Error(fmt::format("{}: names no frames", text));
  std::ranges::sort(choice.these);
  return choice;
}

std::string picture_name(const fs::path& file) {
  const auto frame = frame_of(file);
  if (!frame) return file.filename().string();
  return frame_path(sequence_name(frame->sequence), frame->frame).string();
}

std::vector<fs::path> picture_files(const std::vector<std::string>& arguments,
                                    const FrameChoice& frames, std::optional<FrameTally>* tally) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    const bool is_list = argument.starts_with('@') && !fs::exists(argument);
    const std::vector<fs::path> more =
        is_list ? files_of_list(argument.substr(1)) : files_of(argument);
    files.insert(files.end(), more.begin(), more.end());
  }
  files = with_frames(files, frames, tally);
  std::set<fs::path> seen;
  for (const fs::path& file : files)
    if (!seen.insert(file.lexically_normal()).second)
      throw Error(fmt::format("{}: given twice", file.string()));
  return files;
}

Exclusion::Exclusion(const std::vector<std::string>& patterns) {
  for (const std::string& pattern : patterns) patterns_.push_back({pattern});
}

bool Exclusion::excludes(const fs::path& file) {
  const std::string path = file.string(), name = picture_name(file);
  bool excluded = false;
  for (Pattern& pattern : patterns_) {
    const std::string& text = pattern.text;
    const bool matches = text == path || text == name ||
                         ::fnmatch(text.c_str(), name.c_str(), 0) == 0 ||
                         ::fnmatch(text.c_str(), path.c_str(), 0) == 0;
    pattern.used = pattern.used || matches;
    excluded = excluded || matches;
  }
  return excluded;
}

std::vector<std::string> Exclusion::unused() const {
  std::vector<std::string> texts;
  for (const Pattern& pattern : patterns_)
    if (!pattern.used) texts.push_back(pattern.text);
  return texts;
}

std::vector<std::string> remove_unreadable(std::vector<fs::path>& files,
                                           std::vector<ImageHeader>& headers) {
  std::vector<std::string> messages;
  std::vector<fs::path> readable;
  headers.clear();
  for (const fs::path& file : files) {
    try {
      headers.push_back(read_image_header(file));
      readable.push_back(file);
    } catch (const Error& error) {
      messages.emplace_back(error.what());
    }
  }
  files = std::move(readable);
  return messages;
}

ImageSize common_size(const std::vector<fs::path>& files, const std::vector<ImageHeader>& headers) {
  ImageSize common;
  std::ptrdiff_t most = 0;
  for (const ImageHeader& header : headers)
    if (const auto count = std::ranges::count(headers, header.size, &ImageHeader::size);
        count > most) {
      most = count;
      common = header.size;
      if (2 * static_cast<std::size_t>(count) > headers.size()) break;
    }
  std::vector<std::string> odd;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (headers[i].size != common) odd.push_back(odd_text(files[i], headers[i].size, common));
  if (odd.empty()) return common;
  std::string names;
  for (std::size_t i = 0; i < std::min(odd.size(), kMostNamed); ++i)
    names += (i == 0 ? "" : ", ") + odd[i];
  if (odd.size() > kMostNamed) names += fmt::format(", and {} more", odd.size() - kMostNamed);
  throw Error(fmt::format(
      "{}, but {} of {} pictures are {}: one camera has one image size; {}leave the others out "
      "with --exclude",
      names, most, headers.size(), size_text(common),
      other_turn(headers) ? fmt::format("{}, or ", kSameTurn) : ""));
}

void warn_of_turns(const std::vector<fs::path>& files, const std::vector<ImageHeader>& headers,
                   std::vector<std::string>& warnings) {
  const std::optional<std::size_t> other = other_turn(headers);
  if (!other) return;
  const auto count =
      std::ranges::count(headers, headers[*other].orientation, &ImageHeader::orientation);
  warnings.push_back(fmt::format(
      "{}: its Exif orientation is {}, as that of {} of {} pictures, but {} in {}: the camera was "
      "turned, and in pictures that are turned back the centre of its lens is at another place; {}",
      files[*other].string(), headers[*other].orientation, count, headers.size(),
      headers.front().orientation, files.front().string(), kSameTurn));
}

}  // namespace tagcal::tools
