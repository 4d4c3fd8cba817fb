#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/scene/image.hpp"

// Private to io. All functions throw Error without the file's name.

namespace tagcal::internal {

// A sequence that is being read: frames in ascending order are decoded once. May be used by several
// threads.
class FrameSequence {
 public:
  virtual ~FrameSequence() = default;
  const ImageSequence& about() const { return about_; }

  // Throws Error: there is no such frame, the file ends before it, its size is another one.
  virtual Image8 grey(std::size_t frame) = 0;
  virtual Picture picture(std::size_t frame) = 0;

 protected:
  // `seconds`: ascending, at least one.
  void set_times(std::vector<double> seconds);
  // Throws Error if a frame is not there, or has another size than the first one.
  void check_frame(std::size_t frame) const;
  void check_size(std::size_t frame, const ImageSize& size) const;

  ImageSequence about_;
};

// "FILE:/topic" as both; the topic is "" for a name without one.
struct SequenceName {
  std::filesystem::path file;
  std::string topic;
};
SequenceName split_sequence_name(const std::filesystem::path& sequence);

// The end of a name, in lower case.
std::string ending_of(const std::filesystem::path& file);

// The files of a sequence: those of a folder that are bags of ROS 2, by name.
std::vector<std::filesystem::path> files_of(const SequenceName& name);

// Readers of a video, and of a topic's pictures in one bag or all bags of a folder. Throw as
// read_sequence.
std::shared_ptr<FrameSequence> open_video(const SequenceName& name);
std::shared_ptr<FrameSequence> open_bags(const SequenceName& name);

// The kinds of sequences, by the ends of their names.
bool is_sequence_ending(const std::string& ending);  // in lower case

// The sequence of a name that was read before and has not changed, or a new one. Throws Error.
std::shared_ptr<FrameSequence> frame_sequence(const std::filesystem::path& sequence);

}  // namespace tagcal::internal
