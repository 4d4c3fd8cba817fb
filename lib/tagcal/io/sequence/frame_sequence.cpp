#include "tagcal/io/sequence/frame_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

// A gap between frames is another one than that of most.
bool are_uneven(const std::vector<double>& seconds) {
  constexpr double kShare = 0.1;  // numeric: rounding of stamps to milliseconds stays below
  if (seconds.size() < 3) return false;
  const double mean = (seconds.back() - seconds.front()) / static_cast<double>(seconds.size() - 1);
  for (std::size_t i = 1; i < seconds.size(); ++i)
    if (std::abs(seconds[i] - seconds[i - 1] - mean) > kShare * mean) return true;
  return false;
}

}  // namespace

void FrameSequence::set_times(std::vector<double> seconds) {
  const double first = seconds.front();
  for (double& second : seconds) second -= first;
  about_.times_s = std::move(seconds);
  about_.is_uneven = are_uneven(about_.times_s);
}

void FrameSequence::check_frame(std::size_t frame) const {
  const std::size_t count = about_.times_s.size();
  if (frame >= count)
    throw Error(fmt::format("has {} frames, the last one is number {}", count, count - 1));
}

void FrameSequence::check_size(std::size_t frame, const ImageSize& size) const {
  if (size != about_.size)
    throw Error(fmt::format("changes its size: frame {} is {}x{}, the first one {}x{}", frame,
                            size.width, size.height, about_.size.width, about_.size.height));
}

SequenceName split_sequence_name(const std::filesystem::path& sequence) {
  const std::string text = sequence.string();
  const std::size_t colon = text.rfind(":/");
  if (colon == std::string::npos || colon == 0) return {sequence, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

std::vector<std::filesystem::path> files_of(const SequenceName& name) {
  std::error_code unknown;
  if (!std::filesystem::is_directory(name.file, unknown)) return {name.file};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(name.file, unknown)) {
    const std::string ending = ending_of(entry.path());
    if (ending == ".mcap" || ending == ".db3") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace tagcal::internal
