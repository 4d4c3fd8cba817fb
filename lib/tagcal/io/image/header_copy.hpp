#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "tagcal/io/image/image_codec.hpp"

namespace tagcal::internal {

// Fills `bytes` with the part of an open file that begins at `at`. Throws Error if it cannot be
// read, or the file ends before.
void read_part(int descriptor, std::uint64_t at, std::span<char> bytes);

// The parts of a picture's file that its header needs, at their places in a memory as large as the
// file; the rest is zero and takes no memory. Headers of thousands of pictures need not read their
// pixels. It is a copy: a mapping of a file that another program cuts short meanwhile would end the
// program.
class HeaderCopy {
 public:
  // `descriptor` of an open file of `size` bytes. Throws Error if it cannot be read.
  HeaderCopy(int descriptor, std::size_t size);
  ~HeaderCopy();
  HeaderCopy(const HeaderCopy&) = delete;
  HeaderCopy& operator=(const HeaderCopy&) = delete;

  std::string_view bytes() const { return {memory_, size_}; }

 private:
  // Reads a part of the file, as far as there is one; all of it once as many bytes were asked for.
  void load(std::uint64_t at, std::uint64_t count);
  // A number of a part that was read, as number_at.
  std::optional<std::uint64_t> number(std::uint64_t at, std::size_t count, bool big_endian) const {
    return number_at(bytes(), at, count, big_endian);
  }

  void load_parts();
  void load_png();
  void load_jpeg();
  void load_webp();
  void load_tiff();

  int descriptor_;
  std::size_t size_;
  std::uint64_t num_loaded_ = 0;
  char* memory_;
};

}  // namespace tagcal::internal
