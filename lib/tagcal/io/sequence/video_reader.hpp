#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>

#include "tagcal/io/sequence/ffmpeg.hpp"
#include "tagcal/io/sequence/frame_sequence.hpp"

// Private to io.
namespace tagcal::internal {

class VideoReader : public FrameSequence {
 public:
  // Throws as read_sequence.
  explicit VideoReader(const SequenceName& name);

  Image8 grey(std::size_t frame) override;
  Picture picture(std::size_t frame) override;

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
  bool is_cut_off() const;
  bool decode_next();
  const AVFrame& decoded(std::size_t frame);
  template <typename T>
  Image<T> converted(std::size_t frame, AVPixelFormat format);

  std::filesystem::path file_;
  int orientation_ = 1;  // as Exif's
  std::mutex mutex_;     // of all that follows
  Owned<AVFormatContext> format_;
  Owned<AVCodecContext> codec_;
  Owned<AVPacket> packet_;
  int stream_ = 0;
  bool is_damaged_ = false;  // a packet is
  double end_s_ = 0;         // of the packets that were read, of all streams
  std::size_t num_decoded_ = 0;
  std::deque<Owned<AVFrame>> last_;  // the last ones of those: other threads may still want them
};

}  // namespace tagcal::internal
