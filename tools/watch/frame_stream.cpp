#include "watch/live_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>

#include "job/picture_files.hpp"
#include "job/plain_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

constexpr std::string_view kJpegStart = "\xff\xd8\xff", kJpegEndAndStart = "\xff\xd9\xff\xd8";
constexpr std::string_view kY4mStart = "YUV4MPEG2 ", kY4mFrame = "FRAME";
constexpr std::size_t kMostJpegBytes = std::size_t{64} << 20;  // of a picture
constexpr std::size_t kMostLine = 4096;                        // of a header in Y4M
constexpr double kBlack = 16, kWhite = 235;  // of luma in the limited range (BT.601)

class JpegStream : public FrameStream {
 public:
  std::optional<StreamFrame> next(bool at_end) override {
    if (bytes_.empty()) return std::nullopt;
    if (!bytes_.starts_with(kJpegStart.substr(0, bytes_.size())))
      throw Error("-: the video on stdin is no longer MJPEG");
    const std::size_t end = bytes_.find(kJpegEndAndStart, searched_);
    searched_ = std::max(bytes_.size(), kJpegEndAndStart.size()) - kJpegEndAndStart.size();
    if (end == std::string::npos && bytes_.size() > kMostJpegBytes)
      throw Error("-: a picture of more than 64 MiB");
    if (end == std::string::npos && !at_end) return std::nullopt;
    StreamFrame frame;
    frame.jpeg = bytes_.substr(0, end == std::string::npos ? end : end + 2);
    bytes_.erase(0, frame.jpeg.size());
    searched_ = 0;
    try {
      frame.image = decode_image(frame.jpeg);
    } catch (const Error&) {  // damaged: the camera sends others
    }
    return frame;
  }

 private:
  std::size_t searched_ = 0;  // no picture ends before: a picture comes in many parts
};

// https://wiki.multimedia.cx/index.php/YUV4MPEG2
class Y4mStream : public FrameStream {
 public:
  std::optional<StreamFrame> next(bool) override {
    if (frame_bytes_ == 0 && !read_header()) return std::nullopt;
    const auto line = line_at_start();
    if (!line) return std::nullopt;
    if (!line->starts_with(kY4mFrame)) throw Error("-: the video on stdin is no longer Y4M");
    if (bytes_.size() < line->size() + 1 + frame_bytes_) return std::nullopt;
    StreamFrame frame{Image8({width_, height_}), ""};
    const auto* luma = reinterpret_cast<const std::uint8_t*>(bytes_.data()) + line->size() + 1;
    for (int y = 0; y < height_; ++y, luma += width_)
      std::transform(luma, luma + width_, frame.image.row(y),
                     [&](std::uint8_t v) { return levels_[v]; });
    bytes_.erase(0, line->size() + 1 + frame_bytes_);
    return frame;
  }

 private:
  std::optional<std::string> line_at_start() const {
    const std::size_t end = bytes_.find('\n');
    if (std::min(end, bytes_.size()) > kMostLine) throw Error("-: a header of Y4M has no end");
    if (end == std::string::npos) return std::nullopt;
    return bytes_.substr(0, end);
  }

  bool read_header() {
    const auto line = line_at_start();
    if (!line) return false;
    std::istringstream fields(line->substr(kY4mStart.size()));
    std::string chroma = "420";
    bool is_full = false;
    for (std::string field; fields >> field;) {
      const std::string value = field.substr(1);
      if (field[0] == 'W') width_ = number(value);
      if (field[0] == 'H') height_ = number(value);
      if (field[0] == 'C') chroma = value;
      is_full = is_full || field == "XCOLORRANGE=FULL";
    }
    try {
      check_pixel_count(width_, height_);
    } catch (const Error& error) {
      throw Error(fmt::format("-: {}", error.what()));
    }
    frame_bytes_ = bytes_of(chroma);
    is_full = is_full || chroma == "mono";  // as FFmpeg has it
    for (std::size_t v = 0; v < levels_.size(); ++v) {
      const double share = (static_cast<double>(v) - kBlack) / (kWhite - kBlack);
      levels_[v] = static_cast<std::uint8_t>(is_full ? static_cast<double>(v)
                                                     : std::clamp(255 * share, 0., 255.) + 0.5);
    }
    bytes_.erase(0, line->size() + 1);
    return true;
  }

  static int number(const std::string& text) { return number_of<int>(text).value_or(0); }

  // The number of bytes of a frame, which is its planes.
  std::size_t bytes_of(const std::string& chroma) const {
    const auto w = static_cast<std::size_t>(width_), h = static_cast<std::size_t>(height_);
    if (chroma == "mono") return w * h;
    if (chroma.starts_with("420") && !chroma.starts_with("420p1"))
      return w * h + 2 * ((w + 1) / 2) * ((h + 1) / 2);
    if (chroma == "422") return w * h + 2 * ((w + 1) / 2) * h;
    if (chroma == "411") return w * h + 2 * ((w + 3) / 4) * h;
    if (chroma == "444") return 3 * w * h;
    throw Error(fmt::format(
        "-: Y4M of the kind C{}: 420, 422, 411, 444 and mono of 8 bits are read (ffmpeg .. "
        "-pix_fmt yuv420p)",
        chroma));
  }

  int width_ = 0, height_ = 0;
  std::size_t frame_bytes_ = 0;  // without the line FRAME; 0: the header is not read yet
  std::array<std::uint8_t, 256> levels_{};
};

}  // namespace

std::unique_ptr<FrameStream> frame_stream(std::string_view beginning) {
  const std::string_view ending = ending_of_video(beginning);
  if (ending.empty()) return nullptr;
  if (ending == ".mjpeg") return std::make_unique<JpegStream>();
  return std::make_unique<Y4mStream>();
}

}  // namespace tagcal::tools
