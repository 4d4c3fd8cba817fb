#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

#include "job/frame_motion.hpp"
#include "job/interruption.hpp"

namespace tagcal::tools {

// Cuts a stream of JPEG pictures (MJPEG) into its pictures.
class JpegSplitter {
 public:
  void add(std::string_view bytes);
  // The next whole picture. One that the stream breaks off has no end: `at_end` gives the last one,
  // of which no further picture tells that it is whole.
  std::optional<std::string> next(bool at_end = false);

 private:
  std::string bytes_;
};

// The frames of a camera's live video, MJPEG on stdin, as files of a folder that `tagcal watch`
// follows: one each time that the picture moved and came to rest, so that a frame is a new look at
// the board, and sharp. Named by their number in the video, "000123.jpg".
class LiveFrames {
 public:
  // `keep`: a folder that stays, which must not exist yet; "": a temporary one. Throws Error.
  explicit LiveFrames(const std::filesystem::path& keep);
  ~LiveFrames();
  LiveFrames(const LiveFrames&) = delete;
  LiveFrames& operator=(const LiveFrames&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  bool has_ended() const { return ended_; }  // all frames are in the folder
  std::string problem() const { return ended_ ? problem_ : ""; }

 private:
  void read();
  void take(std::string jpeg);

  bool is_temporary_;
  std::filesystem::path folder_;
  std::error_code why_;
  std::unique_ptr<RemovedOnSignal> removed_;
  FrameMotion motion_;
  double moved_px_ = 0;  // since the last frame that was kept
  bool has_kept_ = false;
  std::size_t frame_ = 0;
  std::string problem_;  // that ended it
  std::atomic<bool> ended_ = false, stop_ = false;
  std::thread reader_;
};

}  // namespace tagcal::tools
