#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/io/types.hpp"

// Sequences of pictures in one file: videos, and the topics of bags. The path of a frame is that of
// the sequence with the frame's number in six digits, "clip.mp4@000123", "a.bag:/camera@000123",
// and the functions of image_file.hpp that read pictures take it. Frames that are read in ascending
// order, by any number of threads, are decoded once.
//
// A topic is named after the bag: "a.bag:/topic" (ROS 1, version 2.0; chunks as they are, bz2 or
// lz4), "a.mcap:/topic" (lz4, zstd; messages of ROS 1 and 2), "a.db3:/topic" (rosbag2's SQLite), or
// "FOLDER:/topic" for the folder of a bag in several files of the last two kinds. Without a topic a
// bag stands for its only topic of pictures. Messages are sensor_msgs' Image and CompressedImage.
//
// The libraries of FFmpeg, liblz4, libzstd, libbz2 and libsqlite3 that tagcal was compiled for are
// loaded when they are first needed; all functions that read throw Error if they are not installed.

namespace tagcal {

// A video by its end, in any case: .mp4, .m4v, .mov, .avi, .mkv, .webm, .mjpeg, .mjpg or .y4m; a bag by
// its, .bag, .mcap or .db3, with or without a topic; or a folder with a topic.
bool is_sequence_name(const std::filesystem::path& sequence);

// What is known without decoding pictures: the file is read once. Of a file that was cut off, the
// frames until there. Throws Error, naming the file: missing, not of these kinds, without frames,
// of an unknown or encrypted codec, no such topic (naming those that there are), messages of
// another type, more than 100 megapixels or a million frames, compressed to more than
// docs/reference/limits.md allows.
ImageSequence read_sequence(const std::filesystem::path& sequence);

// The files that a sequence is read from: of a bag's path the part before the topic.
std::vector<std::filesystem::path> files_of_sequence(const std::filesystem::path& sequence);

std::filesystem::path frame_path(const std::filesystem::path& sequence, std::size_t frame);

// The name of a sequence without folder, ending and topic: "clip", "a".
std::string sequence_name(const std::filesystem::path& sequence);

// The frame that a path names: no value if a file of that name exists, or it is no such path.
struct SequenceFrame {
  std::filesystem::path sequence;
  std::size_t frame = 0;
};
std::optional<SequenceFrame> frame_of(const std::filesystem::path& path);

}  // namespace tagcal
