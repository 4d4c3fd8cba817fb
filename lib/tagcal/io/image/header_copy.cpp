#include "tagcal/io/image/header_copy.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using std::string_view_literals::operator""sv;

// What is read of every file: all of most headers.
constexpr std::size_t kFirstBytes = std::size_t{64} << 10;  // numeric: as fast as a page

}  // namespace

void read_part(int descriptor, std::uint64_t at, std::span<char> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(std::string("cannot be read: ") + std::strerror(errno));
    if (got == 0) throw Error("cannot be read: became shorter meanwhile");
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    at += static_cast<std::uint64_t>(got);
  }
}

HeaderCopy::HeaderCopy(int descriptor, std::size_t size)
    : descriptor_(descriptor),
      size_(size),
      memory_(static_cast<char*>(::mmap(nullptr, size, PROT_READ | PROT_WRITE,
                                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0))) {
  if (memory_ == MAP_FAILED) throw Error("cannot be read: out of memory");
  try {
    load_parts();
  } catch (...) {
    ::munmap(memory_, size_);
    throw;
  }
}

HeaderCopy::~HeaderCopy() { ::munmap(memory_, size_); }

void HeaderCopy::load(std::uint64_t at, std::uint64_t count) {
  if (at >= size_ || num_loaded_ >= size_) return;
  std::uint64_t end = at + std::min(count, size_ - at);
  num_loaded_ += end - at;
  if (num_loaded_ >= size_) {  // parts that overlap, or all of a small file: once is enough
    at = 0;
    end = size_;
  }
  read_part(descriptor_, at, {memory_ + at, end - at});
}

void HeaderCopy::load_parts() {
  load(0, kFirstBytes);
  if (bytes().starts_with("\x89PNG"sv)) load_png();
  if (bytes().starts_with("\xff\xd8"sv)) load_jpeg();
  if (bytes().starts_with("RIFF"sv)) load_webp();
  if (bytes().starts_with("II"sv) || bytes().starts_with("MM"sv)) load_tiff();
}

// Chunks of a length, a name, data and a checksum; IDAT has the pixels.
void HeaderCopy::load_png() {
  for (std::uint64_t at = 8;;) {
    load(at, 8);
    const auto length = number(at, 4, true);
    if (!length || !number(at + 4, 4, true)) return;
    if (bytes().substr(at + 4, 4) != "IDAT"sv) load(at, 12 + *length);
    at += 12 + *length;
  }
}

// Segments of 0xff, a marker and a length that includes itself, up to the scan, 0xda.
void HeaderCopy::load_jpeg() {
  for (std::uint64_t at = 2;;) {
    load(at, 4);
    const auto marker = number(at, 2, true);
    const auto length = number(at + 2, 2, true);
    if (!marker || !length || *marker < 0xff00 || (*marker != 0xffff && *length < 2)) return;
    if (*marker == 0xffff) {  // a fill byte
      ++at;
      continue;
    }
    load(at, 2 + *length);
    if (*marker == 0xffda) return;
    at += 2 + *length;
  }
}

// Chunks of a name, a length and data, which are padded to an even length; those of pixels have a
// header at their beginning.
void HeaderCopy::load_webp() {
  constexpr std::uint64_t kPixelHeader = 64;  // numeric: more than both formats need
  for (std::uint64_t at = 12;;) {
    load(at, 8);
    const auto length = number(at + 4, 4, false);
    if (!length) return;
    const bool pixels = bytes().substr(at, 3) == "VP8"sv || bytes().substr(at, 4) == "ALPH"sv;
    load(at + 8, pixels ? std::min(*length, kPixelHeader) : *length);
    at += 8 + *length + *length % 2;
  }
}

// The first directory: entries of tag, type, count and value, or the place of longer values.
void HeaderCopy::load_tiff() {
  constexpr std::size_t kSizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  const bool big_endian = memory_[0] == 'M';
  const bool big = number(2, 2, big_endian) == 43U;  // BigTIFF
  const std::size_t word = big ? 8 : 4;
  const auto directory = number(big ? 8 : 4, word, big_endian);
  if (!directory) return;
  load(*directory, 8);
  const auto count = number(*directory, big ? 8 : 2, big_endian);
  const std::uint64_t first = *directory + (big ? 8 : 2), step = big ? 20 : 12;
  if (!count || first > size_) return;
  load(first, std::min<std::uint64_t>(*count, size_) * step + word);
  for (std::uint64_t i = 0; i < *count; ++i) {
    const std::uint64_t entry = first + i * step;
    const auto type = number(entry + 2, 2, big_endian);
    const auto values = number(entry + 4, word, big_endian);
    const auto place = number(entry + 4 + word, word, big_endian);
    if (!type || !values || !place) return;
    const std::uint64_t value_size = *type < std::size(kSizes) ? kSizes[*type] : 0;
    const std::uint64_t bytes = std::min<std::uint64_t>(*values, size_) * value_size;
    if (bytes > word) load(*place, bytes);
  }
}

}  // namespace tagcal::internal
