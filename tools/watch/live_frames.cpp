#include "watch/live_frames.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>

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

fs::path temporary_folder() {
  return fs::temp_directory_path() / fmt::format("tagcal-live-{}", ::getpid());
}

}  // namespace

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
    } catch (const std::exception& error) {  // no memory, no room: also the end of the video
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
  std::unique_ptr<FrameStream> stream;
  std::string part(std::size_t{1} << 20, '\0'), beginning;  // a buffer; what came before the stream
  while (!stop_) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, kPoll_ms) == 0) continue;
    const ssize_t got = ::read(STDIN_FILENO, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(fmt::format("-: stdin cannot be read: {}", std::strerror(errno)));
    beginning.append(part, 0, static_cast<std::size_t>(got));
    if (!stream) stream = frame_stream(beginning);
    if (stream) {
      stream->add(std::exchange(beginning, {}));
      while (const auto frame = stream->next(got == 0)) take(*frame);
    }
    if (got == 0) break;
  }
  if (frame_ == 0 && !stop_) throw Error("-: stdin has no picture");
}

void LiveFrames::take(const StreamFrame& frame) {
  const std::size_t number = frame_++;
  if (frame.image.width() == 0) return;
  const double diagonal = std::hypot(frame.image.width(), frame.image.height());
  const double step_px = motion_.take(frame.image).moved_px;
  const bool is_at_rest = number > 0 && step_px < kRestShare * diagonal;
  if (!is_at_rest) moved_px_ += step_px;  // at rest it is noise
  const bool is_new = !has_kept_ || moved_px_ >= kStepShare * diagonal;
  if (!is_new || !is_at_rest) return;
  has_kept_ = true;
  moved_px_ = 0;
  write(frame, number);
}

void LiveFrames::write(const StreamFrame& frame, std::size_t number) const {
  const fs::path file = folder_ / fmt::format("{:06}", number);
  if (frame.jpeg.empty())
    write_png(file.string() + ".png", frame.image);
  else
    write_whole(file.string() + ".jpg", frame.jpeg);
}

}  // namespace tagcal::tools
