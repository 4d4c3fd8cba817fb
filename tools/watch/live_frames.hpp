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
#include "tagcal/scene/image.hpp"

namespace tagcal::tools {

struct StreamFrame {
  Image8 image;      // 0x0: damaged
  std::string jpeg;  // its bytes; empty if the stream is not compressed
};

// Cuts a video that comes in parts into its frames.
class FrameStream {
 public:
  virtual ~FrameStream() = default;
  void add(std::string_view part) { bytes_ += part; }
  // The next whole frame; at the end of the video also the last one of MJPEG, of which no further
  // frame tells that it is whole. Throws Error: another stream, a frame beyond the limits.
  virtual std::optional<StreamFrame> next(bool at_end) = 0;

 protected:
  std::string bytes_;  // that were not yet taken
};

// MJPEG or YUV4MPEG2 (.y4m, 8 bits), as the first bytes say; null if they are too few. Throws Error
// for others.
std::unique_ptr<FrameStream> frame_stream(std::string_view beginning);

// The frames of a camera's live video on stdin (frame_stream), as files of a folder that
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
