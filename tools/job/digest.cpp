#include "job/digest.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <optional>
#include <system_error>

#include "tagcal/io/sequence_file.hpp"

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

std::optional<Digest> digest_of_open(int descriptor) {
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  Digest digest;
  std::string buffer(std::size_t{1} << 20, '\0');
  for (;;) {
    const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) return digest;
    digest.add({buffer.data(), static_cast<std::size_t>(got)});
  }
}

}  // namespace

std::string digest_of(std::string_view text) {
  Digest digest;
  digest.add(text);
  return digest.text();
}

std::string digest_of_file(const std::filesystem::path& file) {
  if (const auto frame = frame_of(file)) {
    std::string state = frame->sequence.string();
    for (const std::filesystem::path& part : files_of_sequence(frame->sequence)) {
      std::error_code unknown;
      state +=
          fmt::format("|{}-{}", std::filesystem::file_size(part, unknown),
                      std::filesystem::last_write_time(part, unknown).time_since_epoch().count());
    }
    return fmt::format("{}@{}", digest_of(state), frame->frame);
  }
  // A device may have no end, and a pipe no writer: opening does not wait for one.
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return "";
  const std::optional<Digest> digest = digest_of_open(descriptor);
  ::close(descriptor);
  return digest ? digest->text() : "";
}

}  // namespace tagcal::tools
