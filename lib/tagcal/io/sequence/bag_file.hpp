#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/sequence/bag_bytes.hpp"
#include "tagcal/io/sequence/ros_image.hpp"

// Private to io: the containers of bags behind one interface. The file is walked once, record after
// record, and the place of each picture is kept; no index of the file is followed, so that one that
// was cut off is read up to there, and one that leads in circles leads nowhere.
namespace tagcal::internal {

struct BagTopic {
  std::string name;
  std::string type;  // "sensor_msgs/Image", of ROS 2, too
  RosCoding coding = RosCoding::ros1;
  std::size_t num_messages = 0;
};

// The place of a message that is a picture.
struct BagMessage {
  std::size_t topic = 0;         // of topics()
  std::int64_t recorded_ns = 0;  // Unix time
  std::int64_t stamp_ns = 0;     // of its header; 0: it has none
  int chunk = -1;                // that is compressed; -1: none
  std::uint64_t at = 0;          // in the file or in the chunk; the key of a row of a table
  std::uint64_t size = 0;
};

class BagFile {
 public:
  virtual ~BagFile() = default;
  const std::vector<BagTopic>& topics() const { return topics_; }
  const std::vector<BagMessage>& pictures() const { return pictures_; }  // in the file's order
  bool is_cut_off() const { return is_cut_off_; }

  // The bytes of a message. Of one thread at a time. Throws Error.
  virtual std::string read(const BagMessage& message) = 0;

 protected:
  // The topic's index: that of an equal one, if there is one. Of a type of ROS 2 "/msg" is left
  // out. Throws Error if there are more than the limits allow.
  std::size_t add_topic(const std::string& name, std::string type, RosCoding coding);
  // Counts a message; keeps its place, if it is a picture. `message.topic`, `recorded_ns`, `chunk`,
  // `at` and `size` are set; `begin`: its first bytes, up to kStampBytes.
  void add_message(BagMessage message, std::string_view begin);

  // Before a part of a bag of `file_size` bytes is unpacked to `size` bytes: throws Error if that
  // is beyond the limits, or all such parts together.
  void allow_unpacking(std::uint64_t size, std::uint64_t file_size);

  std::vector<BagTopic> topics_;
  std::vector<BagMessage> pictures_;
  bool is_cut_off_ = false;

 private:
  std::uint64_t num_unpacked_ = 0;
};

// A file of records, some of which are chunks of others that may be compressed.
class RecordBag : public BagFile {
 public:
  std::string read(const BagMessage& message) override;

 protected:
  explicit RecordBag(const std::filesystem::path& file) : descriptor_(file) {}

  // The records of the file, or of a chunk: `chunk` is its number if it is compressed, else -1.
  // Throws Damage.
  virtual void walk(const BagBytes& bytes, int chunk, bool is_chunk) = 0;
  // Walks all of the file but its first `start` bytes. Damage is where it was cut off.
  void walk_file(std::uint64_t start);
  // Walks a chunk whose stored bytes are a part of the file.
  struct Chunk {
    std::string kind;
    std::uint64_t at = 0;
    std::uint64_t stored = 0;
    std::uint64_t size = 0;
  };
  void walk_chunk(const Chunk& chunk);
  BagBytes bytes() const { return descriptor_.bytes(); }

 private:
  std::string unpacked(const Chunk& chunk) const;

  BagDescriptor descriptor_;
  std::vector<Chunk> chunks_;  // that are compressed
  int last_ = -1;              // the chunk that was unpacked last
  std::string last_bytes_;
};

// Each throws Error: not of this format.
std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& file);
std::unique_ptr<BagFile> open_mcap(const std::filesystem::path& file);
std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& file);

}  // namespace tagcal::internal
