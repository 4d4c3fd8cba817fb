#include "tagcal/io/image/tiff_memory.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace tagcal::internal {

// The functions that libtiff calls for a file. No exception leaves them but for lack of memory.
struct TiffCalls {
  static TiffMemory& memory(thandle_t handle) { return *static_cast<TiffMemory*>(handle); }

  static tmsize_t read(thandle_t handle, void* out, tmsize_t size) {
    TiffMemory& file = memory(handle);
    const std::string_view all = file.readable_.empty() ? file.written_ : file.readable_;
    if (size <= 0 || file.at_ >= all.size()) return 0;
    const std::size_t count = std::min(static_cast<std::size_t>(size), all.size() - file.at_);
    std::memcpy(out, all.data() + file.at_, count);
    file.at_ += count;
    return static_cast<tmsize_t>(count);
  }

  static tmsize_t write(thandle_t handle, void* data, tmsize_t size) {
    TiffMemory& file = memory(handle);
    if (size <= 0) return 0;
    const auto count = static_cast<std::size_t>(size);
    if (file.written_.size() < file.at_ + count) file.written_.resize(file.at_ + count);
    std::memcpy(file.written_.data() + file.at_, data, count);
    file.at_ += count;
    return size;
  }

  static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    TiffMemory& file = memory(handle);
    const toff_t from = whence == SEEK_CUR ? file.at_ : whence == SEEK_END ? size(handle) : 0;
    file.at_ = from + offset;
    return file.at_;
  }

  static toff_t size(thandle_t handle) {
    const TiffMemory& file = memory(handle);
    return file.readable_.empty() ? file.written_.size() : file.readable_.size();
  }

  static int close(thandle_t) { return 0; }

  static int map(thandle_t handle, void** base, toff_t* size) {
    const TiffMemory& file = memory(handle);
    if (file.readable_.empty()) return 0;
    *base = const_cast<char*>(file.readable_.data());  // libtiff does not write into it
    *size = file.readable_.size();
    return 1;
  }

  static void unmap(thandle_t, void*, toff_t) {}

  static int keep_error(TIFF*, void* handle, const char*, const char* format, va_list values) {
    char text[300];
    std::vsnprintf(text, sizeof text, format, values);
    TiffMemory& file = memory(handle);
    if (file.error_.empty()) file.error_ = text;
    return 1;  // do not print it
  }

  static int keep_warning(TIFF*, void* handle, const char*, const char*, va_list) {
    memory(handle).warned_ = true;
    return 1;
  }
};

TiffHandle open_tiff(TiffMemory& memory, const char* mode) {
  constexpr tmsize_t kMostBytes = tmsize_t{1} << 30;  // of one allocation, by sizes in the file
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  if (!options) throw std::bad_alloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), TiffCalls::keep_error, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), TiffCalls::keep_warning, &memory);
  return TiffHandle(TIFFClientOpenExt("picture", mode, &memory, TiffCalls::read, TiffCalls::write,
                                      TiffCalls::seek, TiffCalls::close, TiffCalls::size,
                                      TiffCalls::map, TiffCalls::unmap, options.get()));
}

}  // namespace tagcal::internal
