#include "tagcal/io/sequence_file.hpp"

#include <fmt/format.h>

#include <charconv>

#include "tagcal/error.hpp"
#include "tagcal/io/sequence/frame_sequence.hpp"

namespace tagcal {
using namespace internal;

bool is_sequence_name(const std::filesystem::path& sequence) {
  const SequenceName name = split_sequence_name(sequence);
  std::error_code unknown;
  if (!name.topic.empty() && std::filesystem::is_directory(name.file, unknown)) return true;
  return is_sequence_ending(ending_of(name.file));
}

ImageSequence read_sequence(const std::filesystem::path& sequence) {
  try {
    return frame_sequence(sequence)->about();
  } catch (const Error& error) {
    throw Error(sequence.string() + ": " + error.what());
  }
}

std::vector<std::filesystem::path> files_of_sequence(const std::filesystem::path& sequence) {
  return files_of(split_sequence_name(sequence));
}

std::filesystem::path frame_path(const std::filesystem::path& sequence, std::size_t frame) {
  return fmt::format("{}@{:06}", sequence.string(), frame);
}

std::string sequence_name(const std::filesystem::path& sequence) {
  return split_sequence_name(sequence).file.stem().string();
}

std::optional<SequenceFrame> frame_of(const std::filesystem::path& path) {
  constexpr std::size_t kDigits = 6;  // numeric: at least, as frame_path writes them
  const std::string text = path.string();
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos || text.size() - at - 1 < kDigits) return std::nullopt;
  SequenceFrame found{text.substr(0, at), 0};
  const char* const end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data() + at + 1, end, found.frame);
  if (error != std::errc() || last != end || !is_sequence_name(found.sequence)) return std::nullopt;
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown)) return std::nullopt;
  return found;
}

}  // namespace tagcal
