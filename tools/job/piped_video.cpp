#include "job/piped_video.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "job/interruption.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// Up to a buffer of stdin; "" at its end.
std::string next_part() {
  std::string part(std::size_t{1} << 20, '\0');  // a buffer
  for (;;) {
    const ssize_t got = ::read(STDIN_FILENO, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(fmt::format("-: stdin cannot be read: {}", std::strerror(errno)));
    part.resize(static_cast<std::size_t>(got));
    return part;
  }
}

const char* ending_for(std::string_view beginning) {
  if (beginning.starts_with("\xff\xd8\xff")) return ".mjpeg";
  if (beginning.starts_with("YUV4MPEG2 ")) return ".y4m";
  throw Error(beginning.empty() ? "-: stdin is empty"
                                : "-: stdin is neither MJPEG nor Y4M (ffmpeg .. -f mjpeg -)");
}

// A folder with the file, as long as this lives.
class PipedVideo {
 public:
  PipedVideo()
      : folder_(fs::temp_directory_path() / fmt::format("tagcal-stdin-{}", ::getpid())),
        removed_(folder_, why_) {
    if (why_) throw Error(fmt::format("{}: cannot be made: {}", folder_.string(), why_.message()));
    try {
      read();
    } catch (const Error&) {
      remove();
      throw;
    }
  }
  ~PipedVideo() { remove(); }
  PipedVideo(const PipedVideo&) = delete;
  PipedVideo& operator=(const PipedVideo&) = delete;

  const fs::path& file() const { return file_; }

 private:
  void read() {
    std::string part = next_part();
    file_ = folder_ / (std::string("stdin") + ending_for(part));
    std::ofstream out(file_, std::ios::binary);
    for (; !part.empty(); part = next_part())
      if (!out.write(part.data(), static_cast<std::streamsize>(part.size())))
        throw Error(fmt::format("{}: no room for what stdin sends", file_.string()));
    out.close();
    if (!out) throw Error(fmt::format("{}: no room for what stdin sends", file_.string()));
  }

  void remove() const {
    std::error_code gone;
    fs::remove_all(folder_, gone);
  }

  fs::path folder_, file_;
  std::error_code why_;
  RemovedOnSignal removed_;
};

}  // namespace

fs::path piped_video() {
  static const PipedVideo piped;
  return piped.file();
}

}  // namespace tagcal::tools
