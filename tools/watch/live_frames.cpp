#include "watch/live_frames.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <string_view>
#include <system_error>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// A frame is at rest if it moved by less than this from the frame before it, of the diagonal: 45
// pixels a second at 1280x800 and 30 frames a second, 0.4 px in an exposure of 10 ms.
constexpr double kRestShare = 0.001;
constexpr int kPoll_ms = 100;
constexpr std::string_view kStart = "\xff\xd8\xff";
constexpr std::string_view kEndAndStart = "\xff\xd9\xff\xd8";
constexpr std::size_t kMostBytes = std::size_t{64} << 20;  // of a picture

fs::path temporary_folder() {
  return fs::temp_directory_path() / fmt::format("tagcal-live-{}", ::getpid());
}

}  // namespace

void JpegSplitter::add(std::string_view bytes) {
  bytes_ += bytes;
  if (!kStart.starts_with(std::string_view(bytes_).substr(0, kStart.size())) &&
      !bytes_.starts_with(kStart))
    throw Error("-: stdin is not MJPEG (ffmpeg .. -f mjpeg -)");
  if (bytes_.size() > kMostBytes) throw Error("-: a picture of more than 64 MiB");
}

std::optional<std::string> JpegSplitter::next(bool at_end) {
  const std::size_t end = bytes_.find(kEndAndStart);
  if (end == std::string::npos && (!at_end || bytes_.empty())) return std::nullopt;
  const std::size_t size = end == std::string::npos ? bytes_.size() : end + 2;
  std::string picture = bytes_.substr(0, size);
  bytes_.erase(0, size);
  return picture;
}

LiveFrames::LiveFrames(const fs::path& keep)
    : is_temporary_(keep.empty()), folder_(is_temporary_ ? temporary_folder() : keep) {
  if (is_temporary_)
    removed_ = std::make_unique<RemovedOnSignal>(folder_, why_);
  else if (!fs::create_directories(folder_, why_) && !why_)
    throw Error(fmt::format("--keep: {} exists: give a new folder", folder_.string()));
  if (why_) throw Error(fmt::format("{}: cannot be made: {}", folder_.string(), why_.message()));
  reader_ = std::thread([this] {
    try {
      read();
    } catch (const Error& error) {
      problem_ = error.what();
    }
    ended_ = true;
  });
}

LiveFrames::~LiveFrames() {
  stop_ = true;
  reader_.join();
  if (is_temporary_) fs::remove_all(folder_, why_);
}

void LiveFrames::read() {
  JpegSplitter splitter;
  std::string part(std::size_t{1} << 20, '\0');  // a buffer
  while (!stop_) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, kPoll_ms) == 0) continue;
    const ssize_t got = ::read(STDIN_FILENO, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(fmt::format("-: stdin cannot be read: {}", std::strerror(errno)));
    if (got > 0) splitter.add({part.data(), static_cast<std::size_t>(got)});
    while (auto picture = splitter.next(got == 0)) take(std::move(*picture));
    if (got == 0) break;
  }
  if (frame_ == 0 && !stop_) throw Error("-: stdin has no picture");
}

void LiveFrames::take(std::string jpeg) {
  const std::size_t frame = frame_++;
  const fs::path file = folder_ / fmt::format(".{:06}.part", frame);  // not a picture's name
  Image8 image;
  try {
    write_whole(file, jpeg);
    image = read_image(file);
  } catch (const Error&) {  // damaged: the camera sends others
    std::error_code gone;
    fs::remove(file, gone);
    return;
  }
  const double diagonal = std::hypot(image.width(), image.height());
  const double step_px = motion_.take(image).moved_px;
  const bool is_at_rest = frame > 0 && step_px < kRestShare * diagonal;
  if (!is_at_rest) moved_px_ += step_px;  // at rest it is noise
  const bool is_new = !has_kept_ || moved_px_ >= kStepShare * diagonal;
  std::error_code error;
  if (is_new && is_at_rest) {
    has_kept_ = true;
    moved_px_ = 0;
    fs::rename(file, folder_ / fmt::format("{:06}.jpg", frame), error);
  } else {
    fs::remove(file, error);
  }
}

}  // namespace tagcal::tools
