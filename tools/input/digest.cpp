#include "input/digest.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <system_error>

namespace tagcal::tools {
namespace {

// FNV-1a of 64 bits (Fowler, Noll, Vo; draft-eastlake-fnv-17), continued over parts.
class Digest {
 public:
  void add(std::string_view bytes) {
    for (const char byte : bytes) {
      hash_ ^= static_cast<std::uint8_t>(byte);
      hash_ *= 0x100000001b3ULL;  // numeric: the prime of FNV-1a
    }
    size_ += bytes.size();
  }
  std::string text() const { return fmt::format("{:016x}-{}", hash_, size_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;  // numeric: the offset basis of FNV-1a
  std::uint64_t size_ = 0;
};

}  // namespace

std::string digest_of(std::string_view text) {
  Digest digest;
  digest.add(text);
  return digest.text();
}

std::string digest_of_file(const std::filesystem::path& file) {
  // A device may have no end, and a pipe nobody who writes.
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return "";
  std::ifstream stream(file, std::ios::binary);
  Digest digest;
  std::string buffer(std::size_t{1} << 20, '\0');
  while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) ||
         stream.gcount() > 0)
    digest.add({buffer.data(), static_cast<std::size_t>(stream.gcount())});
  return stream.eof() ? digest.text() : "";
}

}  // namespace tagcal::tools
