#include "tagcal/io/sequence/ffmpeg.hpp"

#include <fmt/format.h>

#include "tagcal/io/image/loaded_library.hpp"

namespace tagcal::internal {
namespace {

Ffmpeg load() {
  const std::string packages = fmt::format("libavformat{} libswscale{}", LIBAVFORMAT_VERSION_MAJOR,
                                           LIBSWSCALE_VERSION_MAJOR);
  const LoadedLibrary util("avutil", LIBAVUTIL_VERSION_MAJOR, "videos", packages);
  const LoadedLibrary codec("avcodec", LIBAVCODEC_VERSION_MAJOR, "videos", packages);
  const LoadedLibrary format("avformat", LIBAVFORMAT_VERSION_MAJOR, "videos", packages);
  const LoadedLibrary scale("swscale", LIBSWSCALE_VERSION_MAJOR, "videos", packages);
  Ffmpeg all{};
  format.find("avformat_open_input", all.avformat_open_input);
  format.find("avformat_find_stream_info", all.avformat_find_stream_info);
  format.find("avformat_close_input", all.avformat_close_input);
  format.find("av_find_best_stream", all.av_find_best_stream);
  format.find("av_read_frame", all.av_read_frame);
  codec.find("avcodec_alloc_context3", all.avcodec_alloc_context3);
  codec.find("avcodec_parameters_to_context", all.avcodec_parameters_to_context);
  codec.find("avcodec_open2", all.avcodec_open2);
  codec.find("avcodec_free_context", all.avcodec_free_context);
  codec.find("avcodec_send_packet", all.avcodec_send_packet);
  codec.find("avcodec_receive_frame", all.avcodec_receive_frame);
  codec.find("av_packet_alloc", all.av_packet_alloc);
  codec.find("av_packet_unref", all.av_packet_unref);
  codec.find("av_packet_free", all.av_packet_free);
  util.find("av_frame_alloc", all.av_frame_alloc);
  util.find("av_frame_clone", all.av_frame_clone);
  util.find("av_frame_free", all.av_frame_free);
  util.find("av_dict_set", all.av_dict_set);
  util.find("av_dict_free", all.av_dict_free);
  util.find("av_log_set_level", all.av_log_set_level);
  util.find("av_display_rotation_get", all.av_display_rotation_get);
  scale.find("sws_getContext", all.sws_getContext);
  scale.find("sws_scale", all.sws_scale);
  scale.find("sws_freeContext", all.sws_freeContext);
  all.av_log_set_level(AV_LOG_QUIET);
  return all;
}

}  // namespace

const Ffmpeg& ffmpeg() {
  static const Ffmpeg all = load();
  return all;
}

}  // namespace tagcal::internal
