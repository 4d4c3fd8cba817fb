#include "tagcal/io/sequence/bag_bytes.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <iterator>
#include <memory>

#include "tagcal/error.hpp"
#include "tagcal/io/image/loaded_library.hpp"

namespace tagcal::internal {
namespace {

struct Bzip2 {
  decltype(&::BZ2_bzBuffToBuffDecompress) decompress;
};
const Bzip2& bzip2() {
  static const Bzip2 all = [] {
    const LoadedLibrary library("bz2", 1, "bags compressed by bz2", "libbz2-1.0");
    Bzip2 found{};
    library.find("BZ2_bzBuffToBuffDecompress", found.decompress);
    return found;
  }();
  return all;
}

struct Lz4 {
  decltype(&::LZ4F_createDecompressionContext) create;
  decltype(&::LZ4F_freeDecompressionContext) free;
  decltype(&::LZ4F_decompress) decompress;
  decltype(&::LZ4F_isError) is_error;
};
const Lz4& lz4() {
  static const Lz4 all = [] {
    const LoadedLibrary library("lz4", 1, "bags compressed by lz4", "liblz4-1");
    Lz4 found{};
    library.find("LZ4F_createDecompressionContext", found.create);
    library.find("LZ4F_freeDecompressionContext", found.free);
    library.find("LZ4F_decompress", found.decompress);
    library.find("LZ4F_isError", found.is_error);
    return found;
  }();
  return all;
}

struct Zstd {
  decltype(&::ZSTD_decompress) decompress;
  decltype(&::ZSTD_isError) is_error;
  decltype(&::ZSTD_getFrameContentSize) content_size;
};
const Zstd& zstd() {
  static const Zstd all = [] {
    const LoadedLibrary library("zstd", 1, "bags compressed by zstd", "libzstd1");
    Zstd found{};
    library.find("ZSTD_decompress", found.decompress);
    library.find("ZSTD_isError", found.is_error);
    library.find("ZSTD_getFrameContentSize", found.content_size);
    return found;
  }();
  return all;
}

// Each fills `out` and returns the number of bytes; throws Damage.
std::size_t unpack_none(std::string_view bytes, std::string& out) {
  if (bytes.size() != out.size()) throw Damage();
  out.assign(bytes);
  return out.size();
}

std::size_t unpack_bz2(std::string_view bytes, std::string& out) {
  auto size = static_cast<unsigned>(out.size());
  std::string in(bytes);  // its interface takes bytes that may be written
  if (bzip2().decompress(out.data(), &size, in.data(), static_cast<unsigned>(in.size()), 0, 0) !=
      BZ_OK)
    throw Damage();
  return size;
}

std::size_t unpack_lz4(std::string_view bytes, std::string& out) {
  LZ4F_decompressionContext_t context = nullptr;
  if (lz4().is_error(lz4().create(&context, LZ4F_VERSION))) throw Damage();
  const std::unique_ptr<LZ4F_dctx, decltype(&::LZ4F_freeDecompressionContext)> owned(context,
                                                                                     lz4().free);
  std::size_t done = 0, taken = 0;
  for (;;) {
    std::size_t room = out.size() - done, in = bytes.size() - taken;
    const std::size_t more =
        lz4().decompress(context, out.data() + done, &room, bytes.data() + taken, &in, nullptr);
    if (lz4().is_error(more)) throw Damage();
    done += room;
    taken += in;
    if (more == 0) return done;
    if (room == 0 && in == 0) throw Damage();  // too short, or longer than it says
  }
}

std::size_t unpack_zstd(std::string_view bytes, std::string& out) {
  const std::size_t size = zstd().decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (zstd().is_error(size)) throw Damage();
  return size;
}

struct Codec {
  std::string_view kind;
  std::size_t (*unpack)(std::string_view bytes, std::string& out);
};
constexpr Codec kCodecs[] = {{"", unpack_none},
                             {"none", unpack_none},
                             {"bz2", unpack_bz2},
                             {"lz4", unpack_lz4},
                             {"zstd", unpack_zstd}};

}  // namespace

std::string decompressed(std::string_view kind, std::string_view bytes, std::uint64_t size) {
  const auto codec = std::ranges::find(kCodecs, kind, &Codec::kind);
  if (codec == std::end(kCodecs))
    throw Error(
        fmt::format("has chunks compressed by \"{}\", which is not read", kind.substr(0, 20)));
  std::string out(static_cast<std::size_t>(size), '\0');
  if (codec->unpack(bytes, out) != size) throw Damage();
  return out;
}

std::uint64_t stated_zstd_size(std::string_view frame) {
  const unsigned long long size = zstd().content_size(frame.data(), frame.size());
  return size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ? 0 : size;
}

}  // namespace tagcal::internal
