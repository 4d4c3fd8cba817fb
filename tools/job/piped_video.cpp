#include "job/picture_files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

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
    while (ending_of_video(part).empty()) {
      const std::string more = next_part();
      if (more.empty()) throw Error(part.empty() ? "-: stdin is empty" : "-: stdin ends too soon");
      part += more;
    }
    file_ = folder_ / fmt::format("stdin{}", ending_of_video(part));
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

std::string_view ending_of_video(std::string_view beginning) {
  constexpr std::pair<std::string_view, std::string_view> kKinds[] = {{"\xff\xd8\xff", ".mjpeg"},
                                                                      {"YUV4MPEG2 ", ".y4m"}};
  bool is_short = false;
  for (const auto& [start, ending] : kKinds) {
    if (beginning.starts_with(start)) return ending;
    is_short |= start.starts_with(beginning);
  }
  if (!is_short) throw Error("-: stdin is neither MJPEG nor Y4M (ffmpeg .. -f mjpeg -)");
  return "";
}

fs::path piped_video() {
  static const PipedVideo piped;
  return piped.file();
}

}  // namespace tagcal::tools
