#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libswscale/swscale.h>
}

// Private to io: the functions of FFmpeg that are used. They are found when they are first needed,
// in the libraries of the versions whose headers were compiled: linked, they would load a hundred
// libraries at each start of a program.

namespace tagcal::internal {

struct Ffmpeg {
  // libavformat
  decltype(&::avformat_open_input) avformat_open_input;
  decltype(&::avformat_find_stream_info) avformat_find_stream_info;
  decltype(&::avformat_close_input) avformat_close_input;
  decltype(&::av_find_best_stream) av_find_best_stream;
  decltype(&::av_read_frame) av_read_frame;
  // libavcodec
  decltype(&::avcodec_alloc_context3) avcodec_alloc_context3;
  decltype(&::avcodec_parameters_to_context) avcodec_parameters_to_context;
  decltype(&::avcodec_open2) avcodec_open2;
  decltype(&::avcodec_free_context) avcodec_free_context;
  decltype(&::avcodec_send_packet) avcodec_send_packet;
  decltype(&::avcodec_receive_frame) avcodec_receive_frame;
  decltype(&::av_packet_alloc) av_packet_alloc;
  decltype(&::av_packet_unref) av_packet_unref;
  decltype(&::av_packet_free) av_packet_free;
  // libavutil
  decltype(&::av_frame_alloc) av_frame_alloc;
  decltype(&::av_frame_clone) av_frame_clone;
  decltype(&::av_frame_free) av_frame_free;
  decltype(&::av_dict_set) av_dict_set;
  decltype(&::av_dict_free) av_dict_free;
  decltype(&::av_log_set_level) av_log_set_level;
  decltype(&::av_display_rotation_get) av_display_rotation_get;
  // libswscale
  decltype(&::sws_getContext) sws_getContext;
  decltype(&::sws_scale) sws_scale;
  decltype(&::sws_freeContext) sws_freeContext;
};

// Throws Error, naming the library, if one is not installed.
const Ffmpeg& ffmpeg();

}  // namespace tagcal::internal
