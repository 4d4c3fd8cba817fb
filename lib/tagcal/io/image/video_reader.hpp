#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>

#include "tagcal/io/image/ffmpeg.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/scene/image.hpp"

// Private to io.
namespace tagcal::internal {

// A video that is being read: frames in ascending order are decoded once. May be used by several
// threads.
class VideoReader {
 public:
  // Throws as read_video.
  explicit VideoReader(const std::filesystem::path& file);

  const Video& video() const { return video_; }

  // Throws Error: there is no such frame, the file ends before it, its size is another one.
  Image8 grey(std::size_t frame);
  ImageRgb colour(std::size_t frame);

 private:
  struct Close {
    void operator()(AVFormatContext* format) const { ffmpeg().avformat_close_input(&format); }
    void operator()(AVCodecContext* codec) const { ffmpeg().avcodec_free_context(&codec); }
    void operator()(AVPacket* packet) const { ffmpeg().av_packet_free(&packet); }
    void operator()(AVFrame* frame) const { ffmpeg().av_frame_free(&frame); }
  };
  template <typename T>
  using Owned = std::unique_ptr<T, Close>;

  void open();
  void survey();
  bool read_packet();
  bool decode_next();
  const AVFrame& decoded(std::size_t frame);
  template <typename T>
  Image<T> converted(std::size_t frame, AVPixelFormat format);

  std::filesystem::path file_;
  Video video_;
  int orientation_ = 1;  // as Exif's
  std::mutex mutex_;     // of all that follows
  Owned<AVFormatContext> format_;
  Owned<AVCodecContext> codec_;
  Owned<AVPacket> packet_;
  int stream_ = 0;
  std::size_t num_decoded_ = 0;
  std::deque<Owned<AVFrame>> last_;  // the last ones of those: other threads may still want them
};

// The reader of a video that was read before and has not changed, or a new one.
std::shared_ptr<VideoReader> video_reader(const std::filesystem::path& file);

}  // namespace tagcal::internal
