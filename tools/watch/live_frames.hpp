#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <thread>

#include "job/frame_motion.hpp"
#include "job/interruption.hpp"
#include "watch/frame_stream.hpp"

namespace tagcal::tools {

// The frames of a camera's live video on stdin (frame_stream.hpp), as files of a folder that
// `tagcal watch` follows: one each time that the picture moved and came to rest, so that a frame is
// a new look at the board, and sharp. Named by their number in the video: "000123.jpg" with the
// bytes of a JPEG, "000123.png" with the grey of a frame that was not compressed.
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
  void take(const StreamFrame& frame);
  void write(const StreamFrame& frame, std::size_t number) const;

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
