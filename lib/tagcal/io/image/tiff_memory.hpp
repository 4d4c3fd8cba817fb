#pragma once

#include <tiffio.h>

#include <memory>
#include <string>
#include <string_view>

namespace tagcal::internal {

// A TIFF file in memory, with the messages of libtiff, which would print them.
class TiffMemory {
 public:
  TiffMemory() = default;                                            // to write
  explicit TiffMemory(std::string_view bytes) : readable_(bytes) {}  // to read; not a copy

  const std::string& written() const { return written_; }
  const std::string& error() const { return error_; }  // the first one, in one line
  bool warned() const { return warned_; }
  void forget_warnings() { warned_ = false; }

 private:
  friend struct TiffCalls;

  std::string_view readable_;
  std::string written_;
  std::size_t at_ = 0;
  std::string error_;
  bool warned_ = false;
};

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, CloseTiff>;

// Opens a file in memory, which must outlive the handle and stay where it is. `mode`: "r" or "w".
// Null if it is not a TIFF.
TiffHandle open_tiff(TiffMemory& memory, const char* mode);

}  // namespace tagcal::internal
