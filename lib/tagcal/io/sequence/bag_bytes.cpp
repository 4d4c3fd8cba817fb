#include "tagcal/io/sequence/bag_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "tagcal/error.hpp"
#include "tagcal/io/image/header_copy.hpp"

namespace tagcal::internal {

BagBytes BagBytes::clipped(std::uint64_t at, std::uint64_t count) const {
  const std::uint64_t first = std::min(at, size_);
  const std::uint64_t size = std::min(count, size_ - first);
  if (descriptor_ < 0) return BagBytes(memory_.substr(first, size));
  return {descriptor_, begin_ + first, size};
}

std::string BagBytes::read(std::uint64_t at, std::uint64_t count) const {
  std::string bytes(static_cast<std::size_t>(count), '\0');
  read_part(descriptor_, begin_ + at, bytes);
  return bytes;
}

std::string BagBytes::part(std::uint64_t at, std::uint64_t count) const {
  constexpr std::uint64_t kAhead = 4096;  // numeric: a page
  if (!holds(at, count)) throw Damage();
  if (descriptor_ < 0) return std::string(memory_.substr(at, count));
  if (count > kAhead) return read(at, count);
  if (at < ahead_at_ || at + count > ahead_at_ + ahead_.size()) {
    ahead_ = read(at, std::min(kAhead, size_ - at));
    ahead_at_ = at;
  }
  return ahead_.substr(at - ahead_at_, count);
}

// Not waiting, as opening a pipe would.
BagDescriptor::BagDescriptor(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (descriptor_ < 0)
    throw Error(errno == ENOENT ? std::string("no such file")
                                : std::string("cannot be read: ") + std::strerror(errno));
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw Error("is not a regular file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

BagDescriptor::~BagDescriptor() { ::close(descriptor_); }

}  // namespace tagcal::internal
