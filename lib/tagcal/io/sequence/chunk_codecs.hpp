#pragma once

#include <cstdint>
#include <string>
#include <string_view>

// Private to io: the compressions of bags. Their libraries are loaded when they are first needed.
namespace tagcal::internal {

// The `size` bytes of a chunk: `kind` is none (or empty), bz2, lz4 (its frame format) or zstd.
// Throws Error for another kind, and if a library is not installed; Damage for bytes of another
// length.
std::string decompressed(std::string_view kind, std::string_view bytes, std::uint64_t size);

// The size that a frame of Zstandard states; 0: none.
std::uint64_t stated_zstd_size(std::string_view frame);

}  // namespace tagcal::internal
