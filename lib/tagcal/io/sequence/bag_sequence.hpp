#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "tagcal/io/sequence/bag_file.hpp"
#include "tagcal/io/sequence/frame_sequence.hpp"

// Private to io.
namespace tagcal::internal {

// The pictures of a topic, of one bag or of all bags in a folder, in the order of their times.
class BagSequence : public FrameSequence {
 public:
  // Throws as read_sequence.
  explicit BagSequence(const SequenceName& name);

  Image8 grey(std::size_t frame) override;
  Picture picture(std::size_t frame) override;

 private:
  struct Frame {
    std::size_t file = 0;
    BagMessage message;
  };
  void take_topic(const std::string& topic);
  void sort_by_time();
  std::string message(std::size_t frame);
  std::unique_ptr<ImageDecoder> decoder(std::size_t frame, const std::string& message) const;

  std::vector<std::unique_ptr<BagFile>> files_;
  std::vector<Frame> frames_;
  std::mutex mutex_;  // of reading files_
};

}  // namespace tagcal::internal
