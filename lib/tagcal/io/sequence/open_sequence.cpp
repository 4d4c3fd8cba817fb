#include "tagcal/io/sequence/frame_sequence.hpp"

#include <algorithm>
#include <iterator>
#include <list>
#include <mutex>
#include <string_view>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/bag_sequence.hpp"
#include "tagcal/io/sequence/video_reader.hpp"

namespace tagcal::internal {
namespace {

using Opener = std::shared_ptr<FrameSequence> (*)(const SequenceName& name);

template <typename Reader>
std::shared_ptr<FrameSequence> open_as(const SequenceName& name) {
  return std::make_shared<Reader>(name);
}

struct SequenceKind {
  std::string_view ending;  // of a file; "": a folder with a topic
  Opener open;
};
constexpr SequenceKind kKinds[] = {
    {".mp4", open_as<VideoReader>},   {".m4v", open_as<VideoReader>},
    {".mov", open_as<VideoReader>},   {".avi", open_as<VideoReader>},
    {".mkv", open_as<VideoReader>},   {".webm", open_as<VideoReader>},
    {".mjpeg", open_as<VideoReader>}, {".mjpg", open_as<VideoReader>},
    {".y4m", open_as<VideoReader>},   {".bag", open_as<BagSequence>},
    {".mcap", open_as<BagSequence>},  {".db3", open_as<BagSequence>},
    {"", open_as<BagSequence>},
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
