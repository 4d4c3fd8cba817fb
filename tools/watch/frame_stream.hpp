#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

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

}  // namespace tagcal::tools
