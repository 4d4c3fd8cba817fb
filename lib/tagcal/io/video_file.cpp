#include "tagcal/io/video_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "tagcal/error.hpp"
#include "tagcal/io/image/video_reader.hpp"

namespace tagcal {

bool is_video_name(const std::filesystem::path& file) {
  constexpr std::string_view kEndings[] = {".mp4", ".m4v",  ".mov",   ".avi",
                                           ".mkv", ".webm", ".mjpeg", ".mjpg"};
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::ranges::find(kEndings, ending) != std::end(kEndings);
}

Video read_video(const std::filesystem::path& file) {
  try {
    return internal::video_reader(file)->video();
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what());
  }
}

std::filesystem::path frame_path(const std::filesystem::path& video, std::size_t frame) {
  return fmt::format("{}@{:06}", video.string(), frame);
}

std::optional<VideoFrame> frame_of(const std::filesystem::path& path) {
  constexpr std::size_t kDigits = 6;  // numeric: at least, as frame_path writes them
  const std::string text = path.string();
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos || text.size() - at - 1 < kDigits) return std::nullopt;
  VideoFrame found{text.substr(0, at), 0};
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data() + at + 1, end, found.frame);
  if (error != std::errc() || last != end || !is_video_name(found.video)) return std::nullopt;
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown)) return std::nullopt;
  return found;
}

}  // namespace tagcal
