#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

// Private to io: the bytes of bags.

namespace tagcal::internal {

// Thrown where bytes end before what they should hold: the bag was cut off, or is damaged.
struct Damage {};

// Values one after the other, little-endian unless told otherwise. Throws Damage at the end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes, bool big_endian = false)
      : bytes_(bytes), big_endian_(big_endian) {}

  bool at_end() const { return at_ == bytes_.size(); }

  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_) throw Damage();
    at_ += static_cast<std::size_t>(count);
    return bytes_.substr(at_ - static_cast<std::size_t>(count), static_cast<std::size_t>(count));
  }

  template <typename Number>
  Number next() {
    const std::string_view bytes = take(sizeof(Number));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      const std::size_t place = big_endian_ ? i : sizeof(Number) - 1 - i;
      value = value << 8 | static_cast<std::uint8_t>(bytes[place]);
    }
    return static_cast<Number>(value);
  }

  // A length of 32 bits and as many bytes.
  std::string_view text() { return take(next<std::uint32_t>()); }

  // Skips to a multiple of `count`.
  void align(std::size_t count) { take((count - at_ % count) % count); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool big_endian_;
};

// An open file, or a part of it, or of a memory that outlives it.
class BagBytes {
 public:
  BagBytes(int descriptor, std::uint64_t begin, std::uint64_t size)
      : descriptor_(descriptor), begin_(begin), size_(size) {}
  explicit BagBytes(std::string_view memory) : memory_(memory), size_(memory.size()) {}

  std::uint64_t begin() const { return begin_; }  // in the file; 0 of a memory
  std::uint64_t size() const { return size_; }
  // As much of a part as there is.
  BagBytes clipped(std::uint64_t at, std::uint64_t count) const;
  bool holds(std::uint64_t at, std::uint64_t count) const {
    return at <= size_ && count <= size_ - at;
  }
  // Throws Damage beyond the end.
  std::string part(std::uint64_t at, std::uint64_t count) const;

  template <typename Number>
  Number number(std::uint64_t at) const {
    return ByteReader(part(at, sizeof(Number))).next<Number>();
  }

 private:
  std::string read(std::uint64_t at, std::uint64_t count) const;

  int descriptor_ = -1;
  std::string_view memory_;
  std::uint64_t begin_ = 0;
  std::uint64_t size_ = 0;
  // What was read ahead: headers of records are short and near one another.
  mutable std::string ahead_;
  mutable std::uint64_t ahead_at_ = 0;
};

// A regular file that stays open. Throws Error if it is none, or cannot be read.
class BagDescriptor {
 public:
  explicit BagDescriptor(const std::filesystem::path& file);
  ~BagDescriptor();
  BagDescriptor(const BagDescriptor&) = delete;
  BagDescriptor& operator=(const BagDescriptor&) = delete;

  BagBytes bytes() const { return {descriptor_, 0, size_}; }

 private:
  int descriptor_;
  std::uint64_t size_ = 0;
};

// Private to io: the compressions of bags. Their libraries are loaded when they are first needed.

// The `size` bytes of a chunk: `kind` is "none", empty, bz2, lz4 (its frame format) or zstd.
// Throws Error for another kind, and if a library is not installed; Damage for bytes of another
// length.
std::string decompressed(std::string_view kind, std::string_view bytes, std::uint64_t size);

// The size that a frame of Zstandard states; 0: none.
std::uint64_t stated_zstd_size(std::string_view frame);

}  // namespace tagcal::internal
