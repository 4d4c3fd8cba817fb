#include "tagcal/io/sequence/frame_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/image/image_codec.hpp"
#include "tagcal/io/sequence/ffmpeg.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

// The kinds that are recognised by their bytes. Playlists, which name other files, are not among
// them.
constexpr const char* kVideoKinds =
    "mov,mp4,m4a,3gp,3g2,mj2,avi,matroska,webm,mjpeg,mpjpeg,yuv4mpegpipe";

// Turned clockwise by the matrix of a phone's recording.
int orientation_of(const AVStream& stream) {
  const std::uint8_t* matrix = nullptr;
#if LIBAVFORMAT_VERSION_MAJOR < 61
  for (int i = 0; i < stream.nb_side_data; ++i)
    if (stream.side_data[i].type == AV_PKT_DATA_DISPLAYMATRIX) matrix = stream.side_data[i].data;
#else
  const AVCodecParameters& codec = *stream.codecpar;
  for (int i = 0; i < codec.nb_coded_side_data; ++i)
    if (codec.coded_side_data[i].type == AV_PKT_DATA_DISPLAYMATRIX)
      matrix = codec.coded_side_data[i].data;
#endif
  if (!matrix) return 1;
  const double degrees =
      -ffmpeg().av_display_rotation_get(reinterpret_cast<const std::int32_t*>(matrix));
  switch ((std::lround(degrees / 90) % 4 + 4) % 4) {
    case 1:
      return 6;
    case 2:
      return 3;
    case 3:
      return 8;
    default:
      return 1;
  }
}

// Times in the unit of the stream as seconds, ascending. Packets without one
// follow the others at the stream's mean rate.
std::vector<double> seconds_of(const std::vector<std::int64_t>& times, const AVStream& stream) {
  const double unit = av_q2d(stream.time_base);
  const double period =
      stream.avg_frame_rate.num > 0 ? 1 / av_q2d(stream.avg_frame_rate) : 0.04;  // numeric: 25 Hz
  std::vector<double> seconds;
  for (std::size_t i = 0; i < times.size(); ++i)
    seconds.push_back(times[i] == AV_NOPTS_VALUE ? static_cast<double>(i) * period
                                                 : static_cast<double>(times[i]) * unit);
  std::ranges::sort(seconds);
  return seconds;
}

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

}  // namespace

VideoReader::VideoReader(const SequenceName& name) : file_(name.file) {
  if (!name.topic.empty()) throw Error("is a video, it has no topics");
  if (!std::filesystem::exists(file_)) throw Error("no such file");
  if (!std::filesystem::is_regular_file(file_)) throw Error("is not a regular file");
  open();
  survey();
  open();
}

void VideoReader::open() {
  const Ffmpeg& av = ffmpeg();
  AVDictionary* options = nullptr;
  av.av_dict_set(&options, "format_whitelist", kVideoKinds, 0);
  av.av_dict_set(&options, "protocol_whitelist", "file", 0);
  AVFormatContext* format = nullptr;
  const int error =
      av.avformat_open_input(&format, ("file:" + file_.string()).c_str(), nullptr, &options);
  av.av_dict_free(&options);
  if (error < 0)
    throw Error(
        "is no video (mp4, mov, avi, mkv, webm, mjpeg, y4m), or is cut off before its index");
  format_.reset(format);
  if (av.avformat_find_stream_info(format, nullptr) < 0) throw Error("is a damaged video");
  const AVCodec* decoder = nullptr;
  stream_ = av.av_find_best_stream(format, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (stream_ == AVERROR_DECODER_NOT_FOUND) throw Error("is a video of an unknown codec");
  if (stream_ < 0) throw Error("has no pictures: it is no video");
  const AVStream& stream = *format->streams[stream_];
  codec_.reset(av.avcodec_alloc_context3(decoder));
  codec_->thread_count = 1;
  if (av.avcodec_parameters_to_context(codec_.get(), stream.codecpar) < 0 ||
      av.avcodec_open2(codec_.get(), decoder, nullptr) < 0)
    throw Error("is a video of a codec that cannot be read");
  packet_.reset(av.av_packet_alloc());
  num_decoded_ = 0;
  last_.clear();
}

// The next packet of the video's stream. Returns false at the end.
bool VideoReader::read_packet() {
  const Ffmpeg& av = ffmpeg();
  for (;;) {
    av.av_packet_unref(packet_.get());
    if (av.av_read_frame(format_.get(), packet_.get()) < 0) return false;
    is_damaged_ |= (packet_->flags & AV_PKT_FLAG_CORRUPT) != 0;
    if (packet_->pts != AV_NOPTS_VALUE)
      end_s_ = std::max(end_s_, static_cast<double>(packet_->pts + packet_->duration) *
                                    av_q2d(format_->streams[packet_->stream_index]->time_base));
    if (packet_->stream_index == stream_) return true;
  }
}

void VideoReader::survey() {
  const AVStream& stream = *format_->streams[stream_];
  const AVCodecParameters& codec = *stream.codecpar;
  check_picture_size(codec.width, codec.height);
  orientation_ = orientation_of(stream);
  about_.size = swaps_sides(orientation_) ? ImageSize{codec.height, codec.width}
                                          : ImageSize{codec.width, codec.height};
  about_.is_interlaced = codec.field_order > AV_FIELD_PROGRESSIVE;
  std::vector<std::int64_t> times;
  while (read_packet()) {
    if ((packet_->flags & AV_PKT_FLAG_DISCARD) != 0) continue;
    if (times.size() == limits::kMaxSequenceFrames)
      throw Error(fmt::format("has more than {} frames", limits::kMaxSequenceFrames));
    times.push_back(packet_->pts);
  }
  if (times.empty()) throw Error("has no frames: it is cut off or encrypted");
  about_.is_cut_off = is_cut_off();
  set_times(seconds_of(times, stream));
}

// After all packets: the last one is incomplete, or all streams end before the time that the header
// says (Matroska has no other sign).
bool VideoReader::is_cut_off() const {
  constexpr double kSameEndS = 0.5;  // numeric: durations are rounded, and sound has its own end
  const bool is_stated = format_->duration_estimation_method == AVFMT_DURATION_FROM_STREAM &&
                         format_->duration != AV_NOPTS_VALUE;
  const std::int64_t start = format_->start_time == AV_NOPTS_VALUE ? 0 : format_->start_time;
  const double stated_end_s = static_cast<double>(start + format_->duration) / AV_TIME_BASE;
  return is_damaged_ || (is_stated && end_s_ + kSameEndS < stated_end_s);
}

// Decodes one more frame into last_. Returns false at the end.
bool VideoReader::decode_next() {
  constexpr std::size_t kKept = 16;  // numeric: more than threads run apart
  const Ffmpeg& av = ffmpeg();
  Owned<AVFrame> frame(av.av_frame_alloc());
  for (;;) {
    const int error = av.avcodec_receive_frame(codec_.get(), frame.get());
    if (error == 0) break;
    if (error != AVERROR(EAGAIN)) return false;
    // A packet that cannot be decoded is passed over, as players do.
    av.avcodec_send_packet(codec_.get(), read_packet() ? packet_.get() : nullptr);
  }
  last_.push_back(std::move(frame));
  if (last_.size() > kKept) last_.pop_front();
  ++num_decoded_;
  return true;
}

const AVFrame& VideoReader::decoded(std::size_t frame) {
  check_frame(frame);
  if (frame + last_.size() < num_decoded_) open();
  while (num_decoded_ <= frame)
    if (!decode_next()) throw Error("ends before this frame: it is cut off or damaged");
  const AVFrame& found = *last_[last_.size() - (num_decoded_ - frame)];
  check_size(frame, swaps_sides(orientation_) ? ImageSize{found.height, found.width}
                                              : ImageSize{found.width, found.height});
  return found;
}

template <typename T>
Image<T> VideoReader::converted(std::size_t frame, AVPixelFormat format) {
  const Ffmpeg& av = ffmpeg();
  const std::lock_guard lock(mutex_);
  const AVFrame& from = decoded(frame);
  constexpr int kAlign = 64;  // numeric: swscale writes whole vectors
  const int bytes = from.width * static_cast<int>(sizeof(T));
  const int stride = (bytes + 2 * kAlign - 1) / kAlign * kAlign;
  std::vector<std::uint8_t> buffer(static_cast<std::size_t>(stride) * (from.height + 1));
  SwsContext* const context = av.sws_getContext(
      from.width, from.height, static_cast<AVPixelFormat>(from.format), from.width, from.height,
      format, SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr);
  if (!context) throw Error("has pixels of a kind that cannot be read");
  std::uint8_t* const planes[] = {buffer.data()};
  const int strides[] = {stride};
  av.sws_scale(context, from.data, from.linesize, 0, from.height, planes, strides);
  av.sws_freeContext(context);
  Image<T> image({from.width, from.height});
  for (int y = 0; y < from.height; ++y)
    std::copy_n(buffer.data() + static_cast<std::ptrdiff_t>(y) * stride, bytes,
                reinterpret_cast<std::uint8_t*>(image.row(y)));
  return upright(std::move(image), orientation_);
}

Image8 VideoReader::grey(std::size_t frame) {
  return converted<std::uint8_t>(frame, AV_PIX_FMT_GRAY8);
}

Picture VideoReader::picture(std::size_t frame) { return converted<Rgb>(frame, AV_PIX_FMT_RGB24); }

std::shared_ptr<FrameSequence> open_video(const SequenceName& name) {
  return std::make_shared<VideoReader>(name);
}

}  // namespace tagcal::internal
