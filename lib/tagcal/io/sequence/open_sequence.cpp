#include "tagcal/io/sequence/frame_sequence.hpp"

#include <algorithm>
#include <iterator>
#include <list>
#include <mutex>
#include <string_view>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

struct SequenceKind {
  std::string_view ending;  // of a file; "": a folder with a topic
  std::shared_ptr<FrameSequence> (*open)(const SequenceName& name);
};
constexpr SequenceKind kKinds[] = {
    {".mp4", open_video}, {".m4v", open_video},  {".mov", open_video},   {".avi", open_video},
    {".mkv", open_video}, {".webm", open_video}, {".mjpeg", open_video}, {".mjpg", open_video},
    {".y4m", open_video}, {".bag", open_bags},   {".mcap", open_bags},   {".db3", open_bags},
    {"", open_bags},
};

// The latest change of the files of a sequence.
std::filesystem::file_time_type time_of_change(const SequenceName& name) {
  std::filesystem::file_time_type latest{};
  for (const std::filesystem::path& file : files_of(name)) {
    std::error_code unknown;
    latest = std::max(latest, std::filesystem::last_write_time(file, unknown));
  }
  return latest;
}

std::shared_ptr<FrameSequence> opened(const SequenceName& name) {
  const std::string ending = std::filesystem::is_directory(name.file) ? "" : ending_of(name.file);
  const auto kind = std::ranges::find(kKinds, ending, &SequenceKind::ending);
  if (kind == std::end(kKinds)) throw Error("is no video and no bag");
  return kind->open(name);
}

}  // namespace

bool is_sequence_ending(const std::string& ending) {
  return !ending.empty() &&
         std::ranges::find(kKinds, ending, &SequenceKind::ending) != std::end(kKinds);
}

std::shared_ptr<FrameSequence> frame_sequence(const std::filesystem::path& sequence) {
  struct Used {
    std::filesystem::path name;
    std::filesystem::file_time_type changed;
    std::shared_ptr<FrameSequence> frames;
  };
  constexpr std::size_t kOpen = 4;  // numeric: of several cameras at once
  static std::mutex mutex;
  static std::list<Used> used;  // the last one first
  const std::lock_guard lock(mutex);
  const SequenceName name = split_sequence_name(sequence);
  const auto changed = time_of_change(name);
  const auto known = std::ranges::find_if(
      used, [&](const Used& u) { return u.name == sequence && u.changed == changed; });
  if (known != used.end()) {
    used.splice(used.begin(), used, known);
    return known->frames;
  }
  used.push_front({sequence, changed, opened(name)});
  if (used.size() > kOpen) used.pop_back();
  return used.front().frames;
}

}  // namespace tagcal::internal
