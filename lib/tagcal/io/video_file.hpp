#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "tagcal/io/types.hpp"

// Videos, whose frames are pictures. The path of a frame is that of the video with the frame's
// number in six digits, "clip.mp4@000123", and the functions of image_file.hpp that read pictures
// take it. Frames that are read in ascending order, by any number of threads, are decoded once.
//
// The libraries of FFmpeg that tagcal was compiled for are loaded when the first video is read; all
// functions that read throw Error if they are not installed.

namespace tagcal {

// By the end of the name, in any case: .mp4, .m4v, .mov, .avi, .mkv, .webm, .mjpeg or .mjpg.
bool is_video_name(const std::filesystem::path& file);

// What is known without decoding: the file is read once. Of a file that was cut off, the frames
// until there. Throws Error, naming the file: missing, not a video of these kinds, without frames,
// of an unknown or encrypted codec, more than 100 megapixels or a million frames.
Video read_video(const std::filesystem::path& file);

std::filesystem::path frame_path(const std::filesystem::path& video, std::size_t frame);

// The frame that a path names: no value if a file of that name exists, or it is no such path.
struct VideoFrame {
  std::filesystem::path video;
  std::size_t frame = 0;
};
std::optional<VideoFrame> frame_of(const std::filesystem::path& path);

}  // namespace tagcal
